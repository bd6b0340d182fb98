//! Data types of objects (CiA 301, 7.1).

/// Data type of an object; the discriminant is the index of its DEFTYPE.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum DataType {
    /// BOOLEAN, transmitted in one byte.
    Boolean = 0x01,
    /// INTEGER8.
    I8 = 0x02,
    /// INTEGER16.
    I16 = 0x03,
    /// INTEGER32.
    I32 = 0x04,
    /// UNSIGNED8.
    U8 = 0x05,
    /// UNSIGNED16.
    U16 = 0x06,
    /// UNSIGNED32.
    U32 = 0x07,
    /// REAL32.
    F32 = 0x08,
    /// VISIBLE_STRING.
    VisibleString = 0x09,
    /// OCTET_STRING.
    OctetString = 0x0A,
    /// DOMAIN.
    Domain = 0x0F,
    /// REAL64.
    F64 = 0x11,
    /// INTEGER64.
    I64 = 0x15,
    /// UNSIGNED64.
    U64 = 0x1B,
}

impl DataType {
    /// Size of a number in bytes; `None` for types without a fixed size.
    #[must_use]
    pub const fn size(self) -> Option<u8> {
        Some(match self {
            Self::Boolean | Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
            Self::VisibleString | Self::OctetString | Self::Domain => return None,
        })
    }

    /// Decodes a little-endian number; signed integers are sign-extended to 64 bits.
    pub(crate) fn decode(self, bytes: &[u8]) -> u64 {
        let raw = bytes
            .iter()
            .take(8)
            .rev()
            .fold(0, |value: u64, byte| value << 8 | u64::from(*byte));
        match self {
            Self::I8 => raw as i8 as u64,
            Self::I16 => raw as i16 as u64,
            Self::I32 => raw as i32 as u64,
            _ => raw,
        }
    }

    /// Maps a value of at most 32 bits to an integer with the same order as the data type.
    pub(crate) const fn ordered(self, bits: u32) -> i32 {
        match self {
            Self::I8 | Self::I16 | Self::I32 => bits as i32,
            // IEEE 754 is sign and magnitude. Minus zero equals zero; NaN is above infinity.
            Self::F32 if bits >> 31 == 1 => -((bits & 0x7FFF_FFFF) as i32),
            Self::F32 => bits as i32,
            // Unsigned: shifted down by half the range.
            _ => (bits ^ 1 << 31) as i32,
        }
    }

    /// The type of a dummy entry in the mapping of an RPDO (CiA 301, 7.4).
    pub(crate) const fn dummy(index: u16) -> Option<Self> {
        Some(match index {
            0x02 => Self::I8,
            0x03 => Self::I16,
            0x04 => Self::I32,
            0x05 => Self::U8,
            0x06 => Self::U16,
            0x07 => Self::U32,
            0x08 => Self::F32,
            0x11 => Self::F64,
            0x15 => Self::I64,
            0x1B => Self::U64,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::DataType;

    #[test]
    fn only_signed_numbers_are_sign_extended() {
        assert_eq!(DataType::I16.decode(&[0xFE, 0xFF]) as i64, -2);
        assert_eq!(DataType::U16.decode(&[0xFE, 0xFF]), 0xFFFE);
        assert_eq!(
            DataType::U64.decode(&[1, 2, 3, 4, 5, 6, 7, 8]),
            0x0807_0605_0403_0201
        );
    }

    #[test]
    fn each_signed_type_is_extended_from_its_own_sign() {
        assert_eq!(DataType::I8.decode(&[0xFE]) as i64, -2);
        assert_eq!(DataType::I32.decode(&[0xFE, 0xFF, 0xFF, 0xFF]) as i64, -2);
        assert_eq!(DataType::U8.decode(&[0xFE]), 0xFE);
    }

    #[test]
    fn unsigned_numbers_are_ordered_beyond_half_their_range() {
        let values = [0, 1, 0x7FFF_FFFF, 0x8000_0000, 0x8000_0001, u32::MAX];
        let order = |value: u32| DataType::U32.ordered(value);
        assert!(
            values
                .windows(2)
                .all(|pair| order(pair[0]) < order(pair[1]))
        );
    }

    #[test]
    fn a_dummy_entry_has_the_index_of_its_type() {
        use DataType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        let types = [I8, I16, I32, U8, U16, U32, F32, F64, I64, U64];
        for data_type in types {
            assert_eq!(DataType::dummy(data_type as u16), Some(data_type));
        }
        let count = (0..=u16::MAX).filter(|index| DataType::dummy(*index).is_some());
        assert_eq!(count.count(), types.len());
    }

    #[test]
    fn floats_are_ordered_numerically() {
        let order = |value: f32| DataType::F32.ordered(value.to_bits());
        let values = [
            f32::NEG_INFINITY,
            -2.0,
            -1.0,
            -1e-30,
            0.0,
            1e-30,
            1.0,
            2.0,
            f32::INFINITY,
        ];
        assert!(
            values
                .windows(2)
                .all(|pair| order(pair[0]) < order(pair[1]))
        );
        assert_eq!(order(-0.0), order(0.0));
        assert!(order(f32::NAN) > order(f32::INFINITY));
    }
}
