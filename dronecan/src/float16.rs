//! Half-precision numbers (IEEE 754 binary16) in the DSDL type `float16`.

/// 2^112: the difference of the exponents' offsets.
const OFFSET: f32 = f32::from_bits(0x7780_0000);

/// The number of these bits; exact.
#[must_use]
pub fn from_bits(bits: u16) -> f32 {
    let sign = u32::from(bits & 0x8000) << 16;
    let magnitude = u32::from(bits & 0x7FFF) << 13;
    let magnitude = if bits & 0x7C00 == 0x7C00 {
        magnitude | 0x7F80_0000
    } else {
        (f32::from_bits(magnitude) * OFFSET).to_bits()
    };
    f32::from_bits(sign | magnitude)
}

/// The bits of the nearest number. A finite one that is too large becomes the largest one.
#[must_use]
pub fn to_bits(value: f32) -> u16 {
    let sign = (value.to_bits() >> 16) as u16 & 0x8000;
    let magnitude = f32::from_bits(value.to_bits() & 0x7FFF_FFFF);
    sign | if value.is_nan() {
        0x7E00
    } else if value.is_infinite() {
        0x7C00
    } else if magnitude >= 65_504.0 {
        0x7BFF
    } else {
        // At most 65,504: 29 bits.
        let scaled = (magnitude / OFFSET).to_bits();
        (scaled.wrapping_add(0xFFF + (scaled >> 13 & 1)) >> 13) as u16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The value by the definition of the format, in double precision.
    fn value(bits: u16) -> f64 {
        let fraction = f64::from(bits & 0x3FF) / 1024.0;
        let magnitude = match bits >> 10 & 31 {
            0 => fraction * 2f64.powi(-14),
            31 if bits & 0x3FF == 0 => f64::INFINITY,
            31 => f64::NAN,
            exponent => (1.0 + fraction) * 2f64.powi(i32::from(exponent) - 15),
        };
        if bits >> 15 == 1 {
            -magnitude
        } else {
            magnitude
        }
    }

    #[test]
    fn every_number_has_its_value_and_returns_to_its_bits() {
        for bits in 0..=u16::MAX {
            let number = from_bits(bits);
            if value(bits).is_nan() {
                assert!(number.is_nan());
                assert!(from_bits(to_bits(number)).is_nan());
            } else {
                assert_eq!(f64::from(number), value(bits));
                assert_eq!(to_bits(number), bits);
            }
        }
    }

    #[test]
    fn numbers_between_two_are_rounded_to_the_nearest() {
        for bits in 0..0x7BFF {
            let (low, high) = (value(bits), value(bits + 1));
            let at = |share: f64| to_bits((low + (high - low) * share) as f32);
            assert_eq!([at(0.25), at(0.75)], [bits, bits + 1]);
        }
        assert_eq!(to_bits(1e9), 0x7BFF);
        assert_eq!(to_bits(-1e9), 0xFBFF);
    }
}
