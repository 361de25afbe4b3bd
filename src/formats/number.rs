//! Numbers as binary files store them, alone or as fields of records.

use super::{arrays::Array, columns::from_origin};

/// Stored value that means a missing NumPy time (NaT).
const NOT_A_TIME: i64 = i64::MIN;

#[derive(Clone, Copy, Debug)]
pub enum Number {
    Float(usize),
    Int(usize),
    Uint(usize),
    Time,
}

impl Number {
    /// Returns the number type of a NumPy kind (`f`, `i`, `u`) with this size (bytes); `None` if there is no such type.
    pub const fn of_kind(kind: char, n_bytes: usize) -> Option<Self> {
        match (kind, n_bytes) {
            ('f', 2 | 4 | 8) => Some(Self::Float(n_bytes)),
            ('i', 1 | 2 | 4 | 8) => Some(Self::Int(n_bytes)),
            ('u', 1 | 2 | 4 | 8) => Some(Self::Uint(n_bytes)),
            _ => None,
        }
    }

    pub const fn n_bytes(self) -> usize {
        match self {
            Self::Float(n_bytes) | Self::Int(n_bytes) | Self::Uint(n_bytes) => n_bytes,
            Self::Time => 8,
        }
    }

    pub fn value(self, bytes: &[u8], is_big_endian: bool) -> f64 {
        self.value_since(bytes, is_big_endian, &mut Some(0))
    }

    pub fn all(self, bytes: &[u8], is_big_endian: bool) -> Vec<f64> {
        let elements = bytes.chunks_exact(self.n_bytes());
        elements.map(|element| self.value(element, is_big_endian)).collect()
    }

    /// Returns the value that these bytes store. Whole numbers are returned minus the origin of their column.
    fn value_since(self, bytes: &[u8], is_big_endian: bool, origin: &mut Option<i64>) -> f64 {
        let mut eight = [0; 8];
        let number = &mut eight[..bytes.len()];
        number.copy_from_slice(bytes);
        if is_big_endian {
            number.reverse();
        }
        let unsigned = u64::from_le_bytes(eight);
        let shift = 64 - 8 * bytes.len() as u32;
        let signed = (unsigned << shift) as i64 >> shift;
        match self {
            Self::Uint(_) => match i64::try_from(unsigned) {
                Ok(number) => from_origin(number, origin),
                Err(_) => unsigned as f64 - origin.unwrap_or(0) as f64,
            },
            Self::Time if signed == NOT_A_TIME => f64::NAN,
            Self::Int(_) | Self::Time => from_origin(signed, origin),
            Self::Float(2) => half(unsigned as u16),
            Self::Float(4) => f64::from(f32::from_bits(unsigned as u32)),
            Self::Float(_) => f64::from_bits(unsigned),
        }
    }
}

/// Decodes a half-precision number: 1 bit sign, 5 bits exponent, 10 bits fraction (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let fraction = f64::from(bits & 0x3ff);
    let size = match bits >> 10 & 0x1f {
        0 => fraction * 2_f64.powi(-24),
        0x1f if fraction == 0.0 => f64::INFINITY,
        0x1f => f64::NAN,
        exponent => (1.0 + fraction / 1024.0) * 2_f64.powi(i32::from(exponent) - 15),
    };
    sign * size
}

/// Field of an array's records: one or more numbers of one type.
#[derive(Debug)]
pub struct Field {
    /// Name of the field; empty if the elements are not records.
    pub name: String,
    pub number: Number,
    pub unit: &'static str,
    pub is_big_endian: bool,
    /// Position of the field's first number in each record (bytes). `n_each` numbers follow one another.
    pub offset: usize,
    pub n_each: usize,
}

/// Values of a field minus the origin of its whole numbers, and this origin (`None` before the first whole number).
pub type FromOrigin = (Vec<f64>, Option<i64>);

impl Field {
    /// Appends the field's numbers of each record to `values`. Panics if the field does not lie within the record.
    pub fn append(&self, records: &[u8], record_bytes: usize, (values, origin): &mut FromOrigin) {
        let n_bytes = self.number.n_bytes();
        for record in records.chunks_exact(record_bytes) {
            let element = &record[self.offset..][..self.n_each * n_bytes];
            let value = |element| self.number.value_since(element, self.is_big_endian, origin);
            values.extend(element.chunks_exact(n_bytes).map(value));
        }
    }

    pub fn array(self, shape: &[usize], (values, origin): FromOrigin) -> Array {
        Array {
            name: self.name,
            unit: self.unit,
            since: origin.unwrap_or(0),
            values,
            shape: match self.n_each {
                1 => shape.to_vec(),
                n_each => [shape, &[n_each]].concat(),
            },
            ..Array::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values from the table of examples of IEEE 754 binary16.
    #[test]
    fn half_precision_numbers_are_those_of_the_standard() {
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 2_f64.powi(-24)),
            (0x0400, 2_f64.powi(-14)),
            (0x3555, 0.333_251_953_125),
            (0xfc00, f64::NEG_INFINITY),
        ] {
            assert_eq!(half(bits), value, "{bits:#x}");
        }
        assert!(half(0x7e00).is_nan());
    }

    #[test]
    fn signed_numbers_of_any_size_keep_their_sign() {
        assert_eq!(Number::Int(1).value(&[0xff], false), -1.0);
        assert_eq!(Number::Int(2).value(&[0x80, 0x00], true), -32768.0);
        assert_eq!(Number::Int(8).value(&(-5_i64).to_le_bytes(), false), -5.0);
        assert_eq!(Number::Uint(4).value(&[0xff; 4], false), 4_294_967_295.0);
        assert!(Number::Time.value(&i64::MIN.to_be_bytes(), true).is_nan());
    }
}
