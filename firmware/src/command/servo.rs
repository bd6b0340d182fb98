//! Commands by the servo pulse of a radio-control receiver.
//!
//! ```text
//! angle = travel (width - centre)/(max - centre)      width >= centre
//! angle = travel (width - centre)/(centre - min)      width <  centre
//! ```

use model_core::control::units::Angle;

use crate::{
    parameters::{CommandSettings, ServoSettings},
    timing::{angle_of_mdeg, periods},
};

impl ServoSettings {
    /// The angle of a pulse; `None` if its width is invalid.
    ///
    /// ```
    /// use firmware::parameters::ServoSettings;
    /// let angle = |width_us| ServoSettings::DEFAULT.angle(width_us).map(|a| a.to_f64());
    /// assert_eq!([1250, 2000, 2150].map(angle), [Some(-30.0), Some(60.0), Some(60.0)]);
    /// assert_eq!([799, 2201].map(angle), [None; 2]);
    /// ```
    pub fn angle(&self, width_us: u16) -> Option<Angle> {
        let (least, greatest) = (self.pulse_min_us, self.pulse_max_us);
        let width_us = i32::from(width_us);
        if width_us < least - self.pulse_margin_us || width_us > greatest + self.pulse_margin_us {
            return None;
        }
        let from_centre = width_us.max(least).min(greatest) - self.pulse_centre_us;
        let half_us = if from_centre < 0 {
            self.pulse_centre_us - least
        } else {
            greatest - self.pulse_centre_us
        };
        // |travel| <= 180,000 and |from_centre| <= 2000: within 3.6e8.
        let scaled = self.pulse_travel_mdeg.checked_mul(from_centre)?;
        Some(angle_of_mdeg(scaled.checked_div(half_us)?))
    }
}

/// The last valid servo pulse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct ServoPulse {
    width_us: u16,
    angle: Option<Angle>,
    /// Control periods since that pulse.
    age: u16,
    glitches: u32,
}

impl ServoPulse {
    /// To be called in each control period with the captured pulse, if any; returns whether it is
    /// valid.
    pub fn update(&mut self, settings: &ServoSettings, width_us: Option<u16>) -> bool {
        self.age = self.age.saturating_add(1);
        let Some(width_us) = width_us else {
            return false;
        };
        match settings.angle(width_us) {
            Some(angle) => {
                self.width_us = width_us;
                self.age = 0;
                self.angle = Some(angle);
                true
            }
            None => {
                self.glitches = self.glitches.saturating_add(1);
                false
            }
        }
    }

    /// Whether the last valid pulse is too old to be followed.
    pub fn is_stale(&self, settings: &CommandSettings) -> bool {
        settings.command_timeout_ms > 0 && self.age > periods(settings.command_timeout_ms)
    }

    /// Discards the angle until the next valid pulse.
    pub fn discard_angle(&mut self) {
        self.angle = None;
    }

    pub fn width_us(&self) -> u16 {
        self.width_us
    }

    pub fn glitches(&self) -> u32 {
        self.glitches
    }

    /// The angle of the last valid pulse.
    pub fn angle(&self) -> Option<Angle> {
        self.angle
    }
}
