//! Messages of ROS 2 in their common serialisation: plain CDR, the low byte first.
//!
//! **Source** OMG DDSI-RTPS, plain CDR: four bytes of encapsulation; then each value at a multiple of its size, counted
//! from there; texts and sequences with their length before them.

/// Reads one message from its start to its end; `None` wherever it ends too early.
pub(super) struct Cdr<'a> {
    body: &'a [u8],
    at: usize,
}

/// Numbers that a message is made of.
pub(super) trait Plain: Copy {
    /// From exactly so many bytes as the number has.
    fn of(bytes: &[u8]) -> Option<Self>;
    fn to_f64(self) -> f64;
}

macro_rules! plain {
    ($($number:ty),*) => {$(
        impl Plain for $number {
            fn of(bytes: &[u8]) -> Option<Self> {
                Some(Self::from_le_bytes(bytes.try_into().ok()?))
            }


            fn to_f64(self) -> f64 {
                self as f64
            }
        }
    )*};
}
plain!(i8, u8, i16, u16, i32, u32, i64, u64, f32, f64);

impl<'a> Cdr<'a> {
    pub(super) fn new(message: &'a [u8]) -> Option<Self> {
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

    pub(super) fn number<N: Plain>(&mut self) -> Option<N> {
        self.at = self.at.next_multiple_of(size_of::<N>());
        N::of(self.bytes(size_of::<N>())?)
    }

    pub(super) fn skip_text(&mut self) -> Option<()> {
        let n_bytes = self.number::<u32>()? as usize;
        self.bytes(n_bytes).map(drop)
    }

    /// Seconds and nanoseconds as nanoseconds, then the name of a frame.
    pub(super) fn header_nanosecs(&mut self) -> Option<i64> {
        let secs = i64::from(self.number::<i32>()?);
        let nanosecs = i64::from(self.number::<u32>()?);
        self.skip_text()?;
        Some(secs * 1_000_000_000 + nanosecs)
    }

    /// Every number of a sequence.
    pub(super) fn sequence<N: Plain>(&mut self) -> Option<Vec<f64>> {
        let n_numbers = self.number::<u32>()? as usize;
        if n_numbers == 0 {
            return Some(Vec::new());
        }
        self.at = self.at.next_multiple_of(size_of::<N>());
        let bytes = self.bytes(n_numbers.checked_mul(size_of::<N>())?)?;
        let numbers = bytes.chunks_exact(size_of::<N>());
        numbers.map(|bytes| N::of(bytes).map(N::to_f64)).collect()
    }

    /// Passes over the texts of a sequence.
    pub(super) fn skip_texts(&mut self) -> Option<()> {
        let n_texts = self.number::<u32>()?;
        (0..n_texts).try_for_each(|_| self.skip_text())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Header, one text of 2 bytes with its end, a number of 8 bytes: it stands at 8 + 4 + 3 = 15, so at 16.
    #[test]
    fn values_stand_at_multiples_of_their_size() {
        let mut message = vec![0, 1, 0, 0];
        message.extend(7_i32.to_le_bytes());
        message.extend(500_000_000_u32.to_le_bytes());
        message.extend(3_u32.to_le_bytes());
        message.extend(b"ft\0\0");
        message.extend(2.5_f64.to_le_bytes());
        let mut cdr = Cdr::new(&message).unwrap();
        assert_eq!(cdr.header_nanosecs(), Some(7_500_000_000));
        assert_eq!(cdr.number::<f64>(), Some(2.5));
        assert_eq!(cdr.number::<u8>(), None);
    }

    #[test]
    fn a_length_that_cannot_be_is_no_sequence() {
        let message = [&[0, 1, 0, 0][..], &u32::MAX.to_le_bytes(), &[0; 16]].concat();
        assert_eq!(Cdr::new(&message).unwrap().sequence::<f64>(), None);
        assert_eq!(Cdr::new(&message).unwrap().skip_texts(), None);
        assert!(Cdr::new(&[0, 0, 0, 0]).is_none(), "the high byte first");
    }
}
