//! The faults of the sensors and their sizes.

use model_core::plant::board::Defects;

/// A kind of fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// The magnet drifts on the shaft.
    Drift,
    /// The magnet slips by an angle at once.
    Slip,
    /// The encoder shows more or less of the travel.
    Scale,
    /// Play between the shaft and the magnet.
    Play,
    /// The gain of the current sense.
    CurrentGain,
}

impl Kind {
    /// Name of its file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Drift => "drift",
            Self::Slip => "slip",
            Self::Scale => "scale",
            Self::Play => "play",
            Self::CurrentGain => "current-gain",
        }
    }

    /// Title and abscissa of its figure.
    pub fn labels(self) -> (&'static str, &'static str) {
        match self {
            Self::Drift => ("The magnet drifts on the shaft", "drift (deg/s)"),
            Self::Slip => ("The magnet slips at once", "slip (deg)"),
            Self::Scale => (
                "The encoder shows another travel",
                "change of the scale (%)",
            ),
            Self::Play => ("Play between shaft and magnet", "play (deg)"),
            Self::CurrentGain => ("Gain of the current sense", "gain (%)"),
        }
    }

    pub fn sizes(self) -> &'static [f64] {
        match self {
            Self::Drift => &[
                -100.0, -60.0, -30.0, -20.0, -10.0, -5.0, -3.0, -2.0, 2.0, 3.0, 5.0, 10.0, 20.0,
                30.0, 60.0, 100.0,
            ],
            Self::Slip => &[
                -45.0, -20.0, -10.0, -5.0, -3.0, -2.0, 2.0, 3.0, 5.0, 10.0, 20.0, 45.0,
            ],
            Self::Scale => &[
                -50.0, -40.0, -30.0, -25.0, -20.0, -10.0, -5.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0,
            ],
            Self::Play => &[1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 20.0],
            Self::CurrentGain => &[
                0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 75.0, 125.0, 150.0, 175.0, 200.0,
            ],
        }
    }

    /// Sets a fault of this size that began so long ago, s.
    pub fn apply(self, size: f64, since_s: f64, defects: &mut Defects) {
        match self {
            Self::Drift => defects.magnet_slip_deg = size * since_s,
            Self::Slip => defects.magnet_slip_deg = size,
            Self::Scale => defects.encoder_loss_pct = -size,
            Self::Play => defects.encoder_play_deg = size,
            Self::CurrentGain => defects.current_loss_pct = 100.0 - size,
        }
    }
}
