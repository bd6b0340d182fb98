//! The bus load of periodic frames.
//!
//! A data frame with an identifier of 11 bits and `n` bytes has `47 + 8 n` bits including the
//! intermission, and at most `floor((34 + 8 n - 1)/4)` stuff bits more (K. Tindell, A. Burns,
//! A. Wellings: Calculating Controller Area Network message response times, 1995).

/// Periodic frames.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Traffic {
    /// Their content.
    pub what: &'static str,
    /// Bytes of data.
    pub bytes: u32,
    /// Their rate, Hz.
    pub rate_hz: f64,
}

/// Bits of a frame without stuff bits, and with the most of them.
///
/// ```
/// use host_sim::can::bus_load::frame_bits;
/// assert_eq!(frame_bits(8), (111, 135));
/// ```
pub const fn frame_bits(bytes: u32) -> (u32, u32) {
    let bits = 47 + 8 * bytes;
    (bits, bits + (34 + 8 * bytes - 1) / 4)
}

/// The frames of one actuator with its default PDOs and a heartbeat, at these rates.
pub fn default_profile(telemetry_hz: f64, command_hz: f64, heartbeat_hz: f64) -> Vec<Traffic> {
    let row = |what, bytes, rate_hz| Traffic {
        what,
        bytes,
        rate_hz,
    };
    vec![
        row(
            "telemetry: angle, rate, back-EMF, current (TPDO 1)",
            8,
            telemetry_hz,
        ),
        row(
            "telemetry: pulse, duty, sample, status (TPDO 2)",
            8,
            telemetry_hz,
        ),
        row("status: statusword, mode, error (TPDO 3)", 5, 50.0),
        row("command: controlword, position (RPDO 3)", 6, command_hz),
        row("heartbeat", 1, heartbeat_hz),
    ]
}

/// The bus load of these frames as a share: without stuff bits, and with the most.
pub fn share(traffic: &[Traffic], bit_rate: f64) -> (f64, f64) {
    let rates = traffic.iter().map(|row| {
        let (least, most) = frame_bits(row.bytes);
        (
            f64::from(least) * row.rate_hz / bit_rate,
            f64::from(most) * row.rate_hz / bit_rate,
        )
    });
    rates.fold((0.0, 0.0), |sum, next| (sum.0 + next.0, sum.1 + next.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_load_of_the_default_pdos_is_that_calculated_by_hand() {
        // 2 x 250 x 135 + 50 x (47 + 40 + 18) + 50 x (47 + 48 + 20) + 10 x (47 + 8 + 10) bit/s.
        let (_, most) = share(&default_profile(250.0, 50.0, 10.0), 1e6);
        assert!((most - (67_500.0 + 5_250.0 + 5_750.0 + 650.0) / 1e6).abs() < 1e-12);
    }

    #[test]
    fn the_longest_frames_are_those_of_the_literature() {
        assert_eq!(frame_bits(0), (47, 55));
        assert_eq!(frame_bits(1), (55, 65));
    }
}
