//! Excitations from integer settings: the constructors of `model_core` compute in double precision,
//! for which the board has no hardware.
//!
//! | shape | is | uses |
//! |---|---|---|
//! | 0 | pulse | amplitude, unit |
//! | 1 | doublet | amplitude, unit |
//! | 2 | 3-2-1-1 | amplitude, unit |
//! | 3 | variable step | amplitude (of its greatest level, 120 deg by default), unit |
//! | 4 | ramp up, down and back | amplitude, rate, unit (holds) |
//! | 5 | linear chirp | amplitude, start, end, duration |
//! | 6 | logarithmic chirp | amplitude, start, end, duration |
//! | 7 | sine | amplitude, start |
//! | 8 | pseudo-random binary sequence | amplitude, order, unit (chip) |
//! | 9 | multisine of odd lines | amplitude (of a line), start (base frequency), lines |

use core::num::{NonZeroU8, NonZeroU64};

use model_core::{
    control::units::Angle,
    excitation::{
        Excitation,
        chirp::{Chirp, Sweep},
        multisine::Multisine,
        multistep::Multistep,
        phase::{Quadratic, ratio},
        prbs::Prbs,
        ramp::Ramp,
        steady_sine::SteadySine,
        variable_step::{LEVELS, VariableStep},
    },
    time::TICKS_PER_SECOND,
};

use super::{Run, logarithmic};
use crate::{
    parameters::{ExcitationSettings, ObjectValues},
    timing::angle_of_mdeg,
};

/// Ticks in a millisecond.
const TICKS_PER_MS: u64 = TICKS_PER_SECOND / 1_000;

/// 1 Hz in 1e-3 Hz, times the ticks in a second.
pub(super) const PER_SECOND: NonZeroU64 = NonZeroU64::new(1_000 * TICKS_PER_SECOND).unwrap();

/// Widths of the steps of pulse, doublet and 3-2-1-1.
const WIDTHS: [&[u8]; 3] = [&[1], &[1, 1], &[3, 2, 1, 1]];

/// Corners of a ramp: time after the start as a number of holds and of rise times to the level, and
/// the level there relative to the amplitude.
const CORNERS: [(u8, u8, i8); 7] = [
    (1, 0, 0),
    (1, 1, 1),
    (2, 1, 1),
    (2, 3, -1),
    (3, 3, -1),
    (3, 4, 0),
    (5, 4, 0),
];

impl ExcitationSettings {
    /// The excitation of these settings; `None` if one is outside its range.
    ///
    /// ```
    /// use firmware::parameters::ExcitationSettings;
    /// let doublet = ExcitationSettings { shape: 1, ..ExcitationSettings::DEFAULT };
    /// let run = doublet.run().unwrap();
    /// assert_eq!(run.excitation.command(0).to_f64(), 5.0);
    /// assert_eq!(run.ticks, 2 * 6_000);
    /// ```
    pub fn run(&self) -> Option<Run> {
        let values = ObjectValues {
            excitation: *self,
            ..ObjectValues::DEFAULT
        };
        values.check().ok()?;
        let amplitude = angle_of_mdeg(self.amplitude_mdeg);
        let unit = self.unit_ticks();
        let excitation = match self.shape {
            3 => Excitation::VariableStep(VariableStep {
                levels: &LEVELS,
                dwell_ticks: unit,
                // The greatest level is 120 deg.
                scale: angle_of_mdeg(self.amplitude_mdeg / 120),
            }),
            4 => Excitation::Ramp(self.ramp(amplitude, unit)),
            5 => self.chirp(amplitude, self.linear()),
            6 => self.chirp(amplitude, self.logarithmic()),
            7 => Excitation::Sine(SteadySine {
                amplitude,
                phase: self.steady(),
                period_ticks: self.period_ticks(),
            }),
            8 => {
                let prbs = Prbs::new(amplitude, self.order as u32, unit, 0);
                Excitation::Prbs(prbs?)
            }
            9 => Excitation::Multisine(Multisine {
                amplitude,
                phase: self.steady(),
                period_ticks: self.period_ticks(),
                first_line: 1,
                line_step: 2,
                lines: NonZeroU8::new(self.lines as u8)?,
            }),
            steps => Excitation::Multistep(Multistep {
                amplitude,
                start_tick: 0,
                unit_ticks: unit,
                widths: WIDTHS.get(steps as usize)?,
            }),
        };
        Some(Run::new(excitation, self.repetitions as u16))
    }

    fn unit_ticks(&self) -> NonZeroU64 {
        NonZeroU64::new(self.unit_ms as u64 * TICKS_PER_MS).unwrap_or(NonZeroU64::MIN)
    }

    fn duration_ticks(&self) -> NonZeroU64 {
        NonZeroU64::new(self.duration_ms as u64 * TICKS_PER_MS).unwrap_or(NonZeroU64::MIN)
    }

    /// Ticks of one period of the frequency, rounded.
    fn period_ticks(&self) -> u64 {
        let frequency_mhz = self.start_mhz as u32;
        let ticks = (PER_SECOND.get() as u32 + frequency_mhz / 2).checked_div(frequency_mhz);
        ticks.unwrap_or(0).into()
    }

    fn ramp(&self, level: Angle, unit: NonZeroU64) -> Ramp {
        let rate_deg_s = self.rate_deg_s as u32;
        // mdeg divided by deg/s are ms. At most 180,000 * 20 ticks.
        let amplitude = self.amplitude_mdeg.unsigned_abs() * TICKS_PER_MS as u32;
        let mut corners = [(0, Angle::ZERO); CORNERS.len()];
        for (corner, &(holds, rises, side)) in corners.iter_mut().zip(&CORNERS) {
            let ticks = (u32::from(rises) * amplitude + rate_deg_s / 2).checked_div(rate_deg_s);
            corner.0 = u64::from(holds) * unit.get() + u64::from(ticks.unwrap_or(0));
            corner.1 = match side {
                0 => Angle::ZERO,
                1 => level,
                _ => -level,
            };
        }
        Ramp::through(&corners)
    }

    fn chirp(&self, amplitude: Angle, sweep: Sweep) -> Excitation<'static> {
        Excitation::Chirp(Chirp {
            amplitude,
            duration_ticks: self.duration_ticks().get(),
            sweep,
        })
    }

    fn steady(&self) -> Quadratic {
        Quadratic {
            per_tick: ratio(self.start_mhz as u64, PER_SECOND, 128),
            per_tick_squared: 0,
        }
    }

    fn linear(&self) -> Sweep {
        let rise = self.end_mhz - self.start_mhz;
        // t^2 (f1 - f0)/(2 T), with 127 instead of 128 bits for the factor 1/2. 2e7 * 7.2e7 < 2^51.
        let length = PER_SECOND.get().saturating_mul(self.duration_ticks().get());
        let length = NonZeroU64::new(length).unwrap_or(PER_SECOND);
        let growth = ratio(rise.unsigned_abs().into(), length, 127);
        Sweep::Linear(Quadratic {
            per_tick_squared: if rise < 0 {
                growth.wrapping_neg()
            } else {
                growth
            },
            ..self.steady()
        })
    }

    fn logarithmic(&self) -> Sweep {
        let ends = [self.start_mhz, self.end_mhz].map(|mhz| mhz as u32);
        logarithmic::sweep(ends, self.duration_ticks())
            .map_or_else(|| self.linear(), Sweep::Logarithmic)
    }
}

#[cfg(test)]
mod tests;
