//! The outputs of an actuator.

/// The outputs of an actuator. A quantity that the model does not have is zero; a measured quantity
/// of a model without sensors has its true value.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reading {
    /// The command that has arrived, deg; 0 where another quantity is commanded.
    pub command_deg: f64,
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Its rate, deg/s.
    pub rate_deg_s: f64,
    /// Duty of the bridge, %.
    pub duty_pct: f64,
    /// Measured angle, deg.
    pub angle_meas_deg: f64,
    /// Measured rate, deg/s.
    pub rate_meas_deg_s: f64,
    /// Motor current, A.
    pub current_a: f64,
    /// Back-EMF, V.
    pub back_emf_v: f64,
}

impl Reading {
    /// The names of the quantities in traces.
    pub const COLUMNS: [&'static str; 8] = [
        "command_delayed_deg",
        "angle_deg",
        "rate_deg_s",
        "duty_pct",
        "angle_meas_deg",
        "rate_meas_deg_s",
        "current_a",
        "back_emf_v",
    ];

    /// All quantities in the order of their declaration.
    pub fn values(&self) -> [f64; 8] {
        [
            self.command_deg,
            self.angle_deg,
            self.rate_deg_s,
            self.duty_pct,
            self.angle_meas_deg,
            self.rate_meas_deg_s,
            self.current_a,
            self.back_emf_v,
        ]
    }
}
