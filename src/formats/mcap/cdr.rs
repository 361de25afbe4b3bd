//! Messages of ROS 2 in their usual serialisation: plain CDR, little-endian.
//!
//! **Source** OMG DDSI-RTPS: an encapsulation header of four bytes, then the values. Each value is aligned to a multiple of
//! its size, counted from the end of the header. Texts and sequences start with their length.

use super::super::number::Number;

/// Reader of one ROS 2 message from start to end. Each method returns `None` if the message ends too early.
pub struct Cdr<'a> {
    body: &'a [u8],
    at: usize,
}

impl<'a> Cdr<'a> {
    pub fn new(message: &'a [u8]) -> Option<Self> {
        const LITTLE_ENDIAN: [u8; 2] = [0, 1];
        let body = message.strip_prefix(&LITTLE_ENDIAN)?.get(2..)?;
        Some(Self { body, at: 0 })
    }

    fn bytes(&mut self, n_bytes: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(n_bytes)?;
        let bytes = self.body.get(self.at..end)?;
        self.at = end;
        Some(bytes)
    }

    pub fn number(&mut self, number: Number) -> Option<f64> {
        self.at = self.at.next_multiple_of(number.n_bytes());
        Some(number.value(self.bytes(number.n_bytes())?, false))
    }

    pub fn length(&mut self) -> Option<usize> {
        Some(self.number(Number::Uint(4))? as usize)
    }

    pub fn skip_text(&mut self) -> Option<()> {
        let n_bytes = self.length()?;
        self.bytes(n_bytes).map(drop)
    }

    /// Reads the header of a ROS 2 message and returns its time stamp (ns). The name of the coordinate frame is skipped.
    pub fn header_nanosecs(&mut self) -> Option<i64> {
        let secs = self.number(Number::Int(4))? as i64;
        let nanosecs = self.number(Number::Uint(4))? as i64;
        self.skip_text()?;
        Some(secs * 1_000_000_000 + nanosecs)
    }

    pub fn sequence(&mut self, number: Number) -> Option<Vec<f64>> {
        let n_numbers = self.length()?;
        if n_numbers == 0 {
            return Some(Vec::new());
        }
        self.at = self.at.next_multiple_of(number.n_bytes());
        let bytes = self.bytes(n_numbers.checked_mul(number.n_bytes())?)?;
        Some(number.all(bytes, false))
    }

    pub fn skip_texts(&mut self) -> Option<()> {
        let n_texts = self.length()?;
        (0..n_texts).try_for_each(|_| self.skip_text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Header, one text of 2 bytes with its end, a number of 8 bytes: the text ends at 15, so the number is aligned to 16.
    #[test]
    fn values_are_aligned_to_their_size() {
        let mut message = vec![0, 1, 0, 0];
        message.extend(7_i32.to_le_bytes());
        message.extend(500_000_000_u32.to_le_bytes());
        message.extend(3_u32.to_le_bytes());
        message.extend(b"ft\0\0");
        message.extend(2.5_f64.to_le_bytes());
        let mut cdr = Cdr::new(&message).unwrap();
        assert_eq!(cdr.header_nanosecs(), Some(7_500_000_000));
        assert_eq!(cdr.number(Number::Float(8)), Some(2.5));
        assert_eq!(cdr.number(Number::Uint(1)), None);
    }

    #[test]
    fn an_impossible_length_is_not_a_sequence() {
        let message = [&[0, 1, 0, 0][..], &u32::MAX.to_le_bytes(), &[0; 16]].concat();
        let sequence = Cdr::new(&message).unwrap().sequence(Number::Float(8));
        assert_eq!(sequence, None);
        assert_eq!(Cdr::new(&message).unwrap().skip_texts(), None);
        assert!(Cdr::new(&[0, 0, 0, 0]).is_none(), "big-endian messages are refused");
    }
}
