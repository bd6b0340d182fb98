//! Excitations by integer settings: their constructors in `model_core` work in double precision,
//! which the board has not.
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
        phase::Quadratic,
        prbs::Prbs,
        ramp::Ramp,
        steady_sine::SteadySine,
        variable_step::{LEVELS, VariableStep},
    },
};

use super::{Run, logarithmic, quotient::quotient};
use crate::{
    parameters::integers::{Integers, integers},
    timing::angle_of_mdeg,
};

integers! {
    /// The excitation that the board runs when it is told to start one. None of it is stored.
    pub struct ExcitationSettings {
        /// Its shape, by the table above.
        shape: 5, "choice", 0, 9, "what identifies best";
        /// Amplitude.
        amplitude_mdeg: 5000, "mdeg", -180000, 180000, "as model-core's chirp";
        /// Frequency, or that at the start.
        start_mhz: 100, "1e-3 Hz", 1, 100000, "as model-core's chirp";
        /// Frequency at the end.
        end_mhz: 10000, "1e-3 Hz", 1, 100000, "as model-core's chirp";
        /// Length of a chirp.
        duration_ms: 20000, "ms", 10, 3600000, "as model-core's chirp";
        /// Width, dwell, hold or chip.
        unit_ms: 300, "ms", 4, 100000, "as model-core's 3-2-1-1";
        /// Slope of a ramp.
        rate_deg_s: 60, "deg/s", 1, 10000, "as model-core's ramp";
        /// Order of the shift register of a pseudo-random binary sequence.
        order: 7, "1", 3, 16, "as model-core's";
        /// Lines of a multisine.
        lines: 8, "1", 1, 8, "each takes 150 instructions of the control period";
        /// How often it is run.
        repetitions: 1, "1", 1, 10000, "once";
    }
}

/// Ticks in a millisecond.
const TICKS_PER_MS: u64 = 20;

const TWO: NonZeroU64 = NonZeroU64::MIN.saturating_add(1);

/// 1e-3 Hz in units of 2^-128 turn a tick.
const PER_TICK: u128 = u128::MAX / 20_000_000;

impl ExcitationSettings {
    /// The run that these settings mean; `None` where one is out of its range.
    ///
    /// ```
    /// use firmware::command::excitation::ExcitationSettings;
    /// let doublet = ExcitationSettings { shape: 1, ..ExcitationSettings::DEFAULT };
    /// let run = doublet.run().unwrap();
    /// assert_eq!(run.excitation.command(0), 5);
    /// assert_eq!(run.ticks, 2 * 6_000);
    /// ```
    pub fn run(&self) -> Option<Run> {
        if self.out_of_range().is_some() {
            return None;
        }
        let excitation = match self.shape {
            0 => self.steps(&[1]),
            1 => self.steps(&[1, 1]),
            2 => self.steps(&[3, 2, 1, 1]),
            3 => self.variable_step(),
            4 => self.ramp(),
            5 => self.chirp(self.linear()),
            6 => self.chirp(self.logarithmic()),
            7 => Excitation::Sine(SteadySine {
                amplitude: self.amplitude(),
                phase: self.steady(),
                period_ticks: self.period_ticks(),
            }),
            8 => Excitation::Prbs(Prbs::new(
                self.amplitude(),
                self.order as u32,
                self.unit_ticks(),
                0,
            )?),
            _ => self.multisine()?,
        };
        let repetitions = self.repetitions as u16;
        // What is periodic goes on without a seam.
        let (runs, more) = if self.shape >= 7 {
            (repetitions, 0)
        } else {
            (1, repetitions.saturating_sub(1))
        };
        Some(Run {
            excitation,
            ticks: self.once_ticks() * u64::from(runs),
            more,
        })
    }

    /// Ticks until all of it has been seen once; below 2^34.
    fn once_ticks(&self) -> u64 {
        let unit = self.unit_ticks().get();
        match self.shape {
            0 => unit,
            1 => 2 * unit,
            2 => 7 * unit,
            3 => LEVELS.len() as u64 * unit,
            4 => self.bend_ticks(5, 4),
            5 | 6 => self.duration_ticks().get(),
            8 => ((1 << self.order) - 1) * unit,
            _ => self.period_ticks(),
        }
    }

    fn amplitude(&self) -> Angle {
        angle_of_mdeg(self.amplitude_mdeg)
    }

    fn unit_ticks(&self) -> NonZeroU64 {
        NonZeroU64::new(self.unit_ms as u64 * TICKS_PER_MS).unwrap_or(NonZeroU64::MIN)
    }

    fn duration_ticks(&self) -> NonZeroU64 {
        NonZeroU64::new(self.duration_ms as u64 * TICKS_PER_MS).unwrap_or(NonZeroU64::MIN)
    }

    /// Ticks of one period of the frequency, rounded.
    fn period_ticks(&self) -> u64 {
        let frequency = NonZeroU64::new(self.start_mhz as u64).unwrap_or(NonZeroU64::MIN);
        (20_000_000 + frequency.get() / 2) / frequency
    }

    fn steps(&self, widths: &'static [u8]) -> Excitation<'static> {
        Excitation::Multistep(Multistep {
            amplitude: self.amplitude(),
            start_tick: 0,
            unit_ticks: self.unit_ticks(),
            widths,
        })
    }

    fn variable_step(&self) -> Excitation<'static> {
        Excitation::VariableStep(VariableStep {
            levels: &LEVELS,
            dwell_ticks: self.unit_ticks(),
            // The greatest level is 120 deg.
            scale: angle_of_mdeg(self.amplitude_mdeg / 120),
        })
    }

    /// Tick of a ramp's bend, behind so many holds and so many times the way to its level.
    fn bend_ticks(&self, holds: u64, ways: u64) -> u64 {
        let rate = NonZeroU64::new(self.rate_deg_s as u64).unwrap_or(NonZeroU64::MIN);
        // mdeg over deg/s are ms.
        let way = u64::from(self.amplitude_mdeg.unsigned_abs()) * TICKS_PER_MS;
        holds * self.unit_ticks().get() + (ways * way + rate.get() / 2) / rate
    }

    fn ramp(&self) -> Excitation<'static> {
        let level = self.amplitude();
        let at = |holds: u64, ways: u64| self.bend_ticks(holds, ways);
        Excitation::Ramp(Ramp::through(&[
            (at(1, 0), Angle::ZERO),
            (at(1, 1), level),
            (at(2, 1), level),
            (at(2, 3), -level),
            (at(3, 3), -level),
            (at(3, 4), Angle::ZERO),
            (at(5, 4), Angle::ZERO),
        ]))
    }

    fn chirp(&self, sweep: Sweep) -> Excitation<'static> {
        Excitation::Chirp(Chirp {
            amplitude: self.amplitude(),
            duration_ticks: self.duration_ticks().get(),
            sweep,
        })
    }

    fn steady(&self) -> Quadratic {
        Quadratic {
            per_tick: self.start_mhz as u128 * PER_TICK,
            per_tick_squared: 0,
        }
    }

    fn linear(&self) -> Sweep {
        let rise = self.end_mhz - self.start_mhz;
        let twice = self.duration_ticks().saturating_mul(TWO);
        // t^2 (f1 - f0)/(2 T): below 2^17 * 2^64 * 2^40.
        let growth = quotient(u64::from(rise.unsigned_abs()), twice) * (PER_TICK >> 64);
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

    fn multisine(&self) -> Option<Excitation<'static>> {
        Some(Excitation::Multisine(Multisine {
            amplitude: self.amplitude(),
            phase: self.steady(),
            period_ticks: self.period_ticks(),
            first_line: 1,
            line_step: 2,
            lines: NonZeroU8::new(self.lines as u8)?,
        }))
    }
}

#[cfg(test)]
mod tests;
