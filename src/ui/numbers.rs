//! Formats durations and long names for the window.

pub use crate::scoring::numbers::{file_size, rate_in_words, significant};

/// Returns a duration rounded up, with a unit that suits its length.
pub fn duration(span: std::time::Duration) -> String {
    let seconds = span.as_secs_f64().ceil() as u64;
    match seconds {
        0..=99 => format!("{seconds} s"),
        100..=5999 => format!("{} min", seconds.div_ceil(60)),
        _ => format!("{:.1} h", seconds as f64 / 3600.0),
    }
}

/// Returns a text of at most `most` characters. A longer text is shortened in the middle, because names differ at their ends.
pub fn elided(text: &str, most: usize) -> String {
    let n = text.chars().count();
    if n <= most {
        return text.to_owned();
    }
    let kept = most.saturating_sub(1);
    let start: String = text.chars().take(kept.div_ceil(2)).collect();
    let end: String = text.chars().skip(n - kept / 2).collect();
    format!("{start}…{end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_name_keeps_its_ends() {
        assert_eq!(elided("train_path1.csv", 15), "train_path1.csv");
        assert_eq!(elided("train_path1_mount2.csv", 11), "train…2.csv");
        assert_eq!(elided("日本語日本語.csv", 5), "日本…sv");
    }

    #[test]
    fn a_span_is_told_as_coarsely_as_one_waits_for_it() {
        let told = |seconds: f64| duration(std::time::Duration::from_secs_f64(seconds));
        assert_eq!(
            [told(0.2), told(99.0), told(130.0), told(9000.0)],
            ["1 s", "99 s", "3 min", "2.5 h"]
        );
    }
}
