//! Status of a sample on a robot or in live rows, as flags.

use std::fmt;
use std::ops::BitOrAssign;

/// Status flags of one sample, of which several may be set. Exported code uses the same bits, except
/// [`Self::AUXILIARY_HELD`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Status(u8);

impl Status {
    /// Status without any flag.
    pub const OK: Self = Self(0);
    /// The history is too short: the state of a feature is not yet determined, or less time has passed since the start than
    /// the longest time threshold t_th or lag.
    pub const FILLING: Self = Self(1);
    /// The sample follows a pause; the samples before it are forgotten.
    pub const AFTER_GAP: Self = Self(2);
    /// The clock was reset; the samples before the reset are forgotten.
    pub const RESTARTED: Self = Self(4);
    /// The load, a gauge or an auxiliary channel (such as temperature) is outside the range for which the calibration is
    /// known.
    pub const BEYOND: Self = Self(8);
    /// The sample was rejected because of an implausible time. It gets no load.
    pub const REJECTED_TIME: Self = Self(16);
    /// The sample was rejected because of its values: too few, too many, or not finite. It gets no load.
    pub const REJECTED_VALUE: Self = Self(32);
    /// An auxiliary channel (such as temperature) holds an outdated value.
    pub const AUXILIARY_HELD: Self = Self(64);

    /// Flags that exported code can set, with their names there.
    pub const EXPORTED: [(&'static str, Self); 6] = [
        ("FILLING", Self::FILLING),
        ("AFTER_GAP", Self::AFTER_GAP),
        ("RESTARTED", Self::RESTARTED),
        ("BEYOND", Self::BEYOND),
        ("REJECTED_TIME", Self::REJECTED_TIME),
        ("REJECTED_VALUE", Self::REJECTED_VALUE),
    ];

    const WORDS: [(Self, &'static str); 7] = [
        (Self::REJECTED_TIME, "rejected: time"),
        (Self::REJECTED_VALUE, "rejected: value"),
        (Self::BEYOND, "beyond"),
        (Self::RESTARTED, "restarted"),
        (Self::AFTER_GAP, "after a gap"),
        (Self::AUXILIARY_HELD, "auxiliary held"),
        (Self::FILLING, "filling"),
    ];

    /// Returns the flags as a number.
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Returns true if at least one of the flags in `any` is set.
    pub const fn has(self, any: Self) -> bool {
        self.0 & any.0 != 0
    }
}

impl BitOrAssign for Status {
    fn bitor_assign(&mut self, more: Self) {
        self.0 |= more.0;
    }
}

/// Writes the names of the flags that are set, joined by `+`. After a pause or restart, `filling` is omitted, because it is
/// always set then.
impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let begins = self.has(Self(Self::AFTER_GAP.0 | Self::RESTARTED.0));
        let words = Self::WORDS.iter().filter(|(flag, _)| self.has(*flag));
        let words = words.filter(|(flag, _)| !(begins && *flag == Self::FILLING));
        let words: Vec<&str> = words.map(|(_, word)| *word).collect();
        if words.is_empty() { f.write_str("ok") } else { f.write_str(&words.join("+")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flag_has_a_text_and_filling_is_omitted_after_a_gap_or_restart() {
        let words = |bits| Status(bits).to_string();
        assert_eq!(words(0), "ok");
        assert_eq!(words(1 + 8), "beyond+filling");
        assert_eq!(words(1 + 2 + 8), "beyond+after a gap");
        assert_eq!(words(4 + 64), "restarted+auxiliary held");
        assert_eq!(words(32), "rejected: value");
        let all = Status::WORDS.iter().fold(0, |all, (flag, _)| all ^ flag.0);
        assert_eq!(all, 127);
    }
}
