//! The bring-up of a board: steps in their order, and the range that each measurement must be in.
//!
//! A program measures; [`BringUp`] judges. Each step presupposes that all before it have passed: no
//! step follows one that fails, so that outputs are only switched on while supply, measurements and
//! watchdog are known to work. No motor is connected before the last step has passed.

use model_core::{
    control::units::{Percent, percent},
    sensors::{
        adc::AdcCode,
        dividers::{LEG_DIVIDER, SUPPLY_DIVIDER},
    },
};

/// Duty that the bridge is driven with, either way: the greatest of the program.
pub const DUTY: Percent = percent(10.0);

/// Readings of the encoder, and frames on the bus, that a step takes.
pub const REPETITIONS: i32 = 64;

/// Time for a person to act, ms.
pub const PATIENCE_MS: u32 = 30_000;

/// A step, in the order of the bring-up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Step {
    /// The watchdog resets a program that does not feed it: ms until then.
    Watchdog,
    /// Supply, mV.
    Supply,
    /// Temperature, mdegC.
    Temperature,
    /// Motor current with open switches, mA.
    CurrentAtRest,
    /// Leg A with open switches, thousandths of the supply.
    LegAAtRest,
    /// Leg B with open switches, thousandths of the supply.
    LegBAtRest,
    /// Valid readings of the encoder, of [`REPETITIONS`].
    Encoder,
    /// Counts between the extreme readings of the encoder at rest.
    EncoderAtRest,
    /// Trips of the bridge while nothing trips it: its input is high.
    BreakReleased,
    /// Leg A less leg B in the on time at a positive duty, thousandths of the supply.
    Forward,
    /// The same at a negative duty.
    Backward,
    /// Greatest amount of the current in these two, mA: no motor is connected.
    NoMotor,
    /// The outputs go off when the break input is pulled low, by a person: 1 if so.
    Break,
    /// Frames received in the loop back of the CAN controller, of [`REPETITIONS`].
    CanController,
    /// Frames that another node has acknowledged, of [`REPETITIONS`].
    CanBus,
    /// Way of the shaft, turned by hand, in counts without a jump.
    ShaftByHand,
    /// Brown-out reset level of the option bytes.
    BrownOut,
}

/// What a measurement gives that could not be taken: in no range.
pub const NOT_MEASURED: i32 = i32::MIN;

impl Step {
    /// All steps in their order.
    pub const ALL: [Self; 17] = [
        Self::Watchdog,
        Self::Supply,
        Self::Temperature,
        Self::CurrentAtRest,
        Self::LegAAtRest,
        Self::LegBAtRest,
        Self::Encoder,
        Self::EncoderAtRest,
        Self::BreakReleased,
        Self::Forward,
        Self::Backward,
        Self::NoMotor,
        Self::Break,
        Self::CanController,
        Self::CanBus,
        Self::ShaftByHand,
        Self::BrownOut,
    ];

    /// The least and the greatest measurement that passes.
    ///
    /// ```
    /// use firmware::bring_up::Step;
    /// assert_eq!(Step::Supply.range(), (4560, 7600));
    /// ```
    pub const fn range(self) -> (i32, i32) {
        match self {
            // 17 to 48 ms (`docs/hardware.md`, off states), and a ms before it counts.
            Self::Watchdog => (16, 48),
            // 4.8 to 7.25 V, each with 5 %: divider and reference have 4.6 %.
            Self::Supply => (4_560, 7_600),
            // A room; an open or shorted NTC is beyond.
            Self::Temperature => (5_000, 45_000),
            // Offset and reference of the amplifier: 10 mA; the converter: 4 codes of 1.6 mA.
            Self::CurrentAtRest | Self::NoMotor => (-20, 20),
            // Half the supply; resistors of 1 % and the input currents of the amplifier: 2.5 %.
            Self::LegAAtRest | Self::LegBAtRest => (450, 550),
            Self::Encoder | Self::CanController | Self::CanBus => (REPETITIONS, REPETITIONS),
            // The noise of the encoder is below a count rms.
            Self::EncoderAtRest => (0, 4),
            Self::BreakReleased => (0, 0),
            // The switches drop nothing without a motor; two dividers of 1 % differ by 2.7 %.
            Self::Forward => (950, 1_050),
            Self::Backward => (-1_050, -950),
            Self::Break => (1, 1),
            // 45 deg, either way.
            Self::ShaftByHand => (512, i32::MAX),
            // 2.7 V, which writing the flash in words requires.
            Self::BrownOut => (3, 3),
        }
    }

    /// Its name in the log.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Watchdog => "watchdog (ms)",
            Self::Supply => "supply (mV)",
            Self::Temperature => "temperature (mdegC)",
            Self::CurrentAtRest => "current at rest (mA)",
            Self::LegAAtRest => "leg A at rest (1/1000 of the supply)",
            Self::LegBAtRest => "leg B at rest (1/1000 of the supply)",
            Self::Encoder => "encoder (valid readings)",
            Self::EncoderAtRest => "encoder at rest (counts)",
            Self::BreakReleased => "break input released (trips)",
            Self::Forward => "legs at +10 % (1/1000 of the supply)",
            Self::Backward => "legs at -10 % (1/1000 of the supply)",
            Self::NoMotor => "no motor (mA)",
            Self::Break => "break input (1 if it opens the switches)",
            Self::CanController => "CAN controller (frames)",
            Self::CanBus => "CAN bus (acknowledged frames)",
            Self::ShaftByHand => "shaft by hand (counts)",
            Self::BrownOut => "brown-out reset (level)",
        }
    }

    /// Whether a measurement is in the range.
    ///
    /// ```
    /// use firmware::bring_up::{NOT_MEASURED, Step};
    /// assert!(Step::CurrentAtRest.passes(-3));
    /// assert!(!Step::CurrentAtRest.passes(NOT_MEASURED));
    /// ```
    pub const fn passes(self, measured: i32) -> bool {
        let (least, most) = self.range();
        least <= measured && measured <= most
    }
}

/// What is known of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Verdict {
    /// It has not run.
    Open = 0,
    /// It has passed.
    Passed = 1,
    /// It has failed, and none follows.
    Failed = 2,
}

/// The progress of a bring-up.
#[derive(Debug, Default)]
pub struct BringUp {
    passed: usize,
    has_failed: bool,
}

impl BringUp {
    /// The step that is to be measured next; `None` after the last one, and after a failure.
    pub fn next(&self) -> Option<Step> {
        match self.has_failed {
            true => None,
            false => Step::ALL.get(self.passed).copied(),
        }
    }

    /// Judges the measurement of the next step.
    ///
    /// ```
    /// use firmware::bring_up::{BringUp, Step, Verdict};
    /// let mut bring_up = BringUp::default();
    /// assert_eq!(bring_up.judge(25), Verdict::Passed);
    /// assert_eq!(bring_up.next(), Some(Step::Supply));
    /// assert_eq!(bring_up.judge(3300), Verdict::Failed);
    /// assert_eq!(bring_up.next(), None);
    /// ```
    pub fn judge(&mut self, measured: i32) -> Verdict {
        match self.next() {
            Some(step) if step.passes(measured) => {
                self.passed += 1;
                Verdict::Passed
            }
            Some(_) => {
                self.has_failed = true;
                Verdict::Failed
            }
            None => Verdict::Open,
        }
    }

    /// Whether every step has passed: a motor may be connected.
    pub fn is_complete(&self) -> bool {
        self.passed == Step::ALL.len()
    }
}

/// A leg in thousandths of the supply, from their codes; 0 without a supply.
///
/// ```
/// use firmware::bring_up::permille;
/// use model_core::sensors::dividers::{leg_code, supply_code};
/// assert_eq!(permille(leg_code(3.0), supply_code(6.0)), 500);
/// ```
pub const fn permille(leg: AdcCode, supply: AdcCode) -> i32 {
    const SCALE: i32 = (SUPPLY_DIVIDER / LEG_DIVIDER * 1000.0 + 0.5) as i32;
    // 4095 times 600 is below 2^22.
    let (leg, supply) = (leg.bits() as i32 * SCALE, supply.bits() as i32);
    match leg.checked_div(supply) {
        Some(ratio) => ratio,
        None => 0,
    }
}

/// The way of a shaft from readings of its angle: the greatest distance from the first one.
#[derive(Debug, Clone, Copy, Default)]
pub struct Way {
    last: Option<i32>,
    position: i32,
    greatest: i32,
}

/// Most counts between two readings a millisecond apart: 17 deg, far above what a hand does.
const JUMP: i32 = 200;

impl Way {
    /// Adds a reading; returns the greatest distance so far, counts, or `None` after a jump.
    ///
    /// ```
    /// use firmware::bring_up::Way;
    /// let mut way = Way::default();
    /// assert_eq!(way.add(4090), Some(0));
    /// assert_eq!(way.add(14), Some(20)); // across zero
    /// assert_eq!(way.add(2000), None);
    /// ```
    pub fn add(&mut self, count: u16) -> Option<i32> {
        let count = i32::from(count);
        if let Some(last) = self.last {
            // The shorter way around: -2048 to 2047.
            let step = ((count - last + 2048) & 4095) - 2048;
            if step.abs() > JUMP {
                return None;
            }
            self.position += step;
            self.greatest = self.greatest.max(self.position.abs());
        }
        self.last = Some(count);
        Some(self.greatest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_steps_are_numbered_in_their_order() {
        let numbers = Step::ALL.map(|step| step as usize);
        assert!(numbers.into_iter().eq(0..Step::ALL.len()));
    }

    #[test]
    fn nothing_follows_a_failed_step() {
        for failing in 0..Step::ALL.len() {
            let mut bring_up = BringUp::default();
            for step in Step::ALL.into_iter().take(failing) {
                assert_eq!(bring_up.next(), Some(step));
                assert_eq!(bring_up.judge(step.range().0), Verdict::Passed);
            }
            assert_eq!(bring_up.judge(NOT_MEASURED), Verdict::Failed);
            assert_eq!((bring_up.next(), bring_up.judge(0)), (None, Verdict::Open));
            assert!(!bring_up.is_complete());
        }
    }

    #[test]
    fn all_steps_make_a_complete_bring_up() {
        let mut bring_up = BringUp::default();
        while let Some(step) = bring_up.next() {
            assert_eq!(bring_up.judge(step.range().1), Verdict::Passed);
        }
        assert!(bring_up.is_complete());
    }

    #[test]
    fn the_way_is_the_greatest_distance_either_way() {
        let mut way = Way::default();
        for count in [100u16, 50, 0, 4046, 4000] {
            assert!(way.add(count).is_some());
        }
        assert_eq!(way.add(100), Some(196));
    }
}
