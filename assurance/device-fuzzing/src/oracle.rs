//! Invariants of every control period, for all frames and measurements.

use std::collections::BTreeSet;

use canopen::CanFrame;
use embedded_can::Frame;
use firmware::application::{BoardState, Bridge, Outputs, Samples, Scan};
use firmware::measure;
use firmware::parameters::BoardParameters;
use model_core::control::encoder_word::COUNT_DEG;
use model_core::control::units::Rate;
use model_core::time::CONTROL_PERIOD_US;

/// Controlword bits of operation enabled (CiA 402-2, table 27).
const ENABLE_OPERATION: u8 = 0x0f;

/// Control periods of a fault reaction beyond its longest time: those of the transitions into and
/// out of it.
const SLACK_PERIODS: u32 = 4;

/// Resolution of the angle: some units of its last place, deg.
const RESOLUTION_DEG: f64 = 1e-3;

/// A control period: parameters at its start, what was measured, and what was decided.
#[derive(Debug)]
pub struct Period {
    /// The parameters.
    pub settings: BoardParameters,
    /// The limit of the duty, percent.
    pub duty_limit_pct: f64,
    /// The samples.
    pub samples: Samples,
    /// The outputs.
    pub outputs: Outputs,
}

/// What a run reached.
#[derive(Debug, Clone, Default)]
pub struct Summary {
    /// Control periods.
    pub periods: u32,
    /// Control periods in which the motor was driven.
    pub driven: u32,
    /// The states.
    pub states: BTreeSet<u8>,
    /// Numbers of the first faults.
    pub faults: BTreeSet<u8>,
}

/// Checks each control period.
#[derive(Debug, Default)]
pub struct Oracle {
    summary: Summary,
    /// A frame may have commanded the state "operation enabled".
    may_drive: bool,
    before: Option<Outputs>,
    /// The angle when it changed last, deg, and the count of that period.
    accepted: Option<(f64, i32)>,
    /// The parameters of the period before.
    settings: Option<BoardParameters>,
    /// Control periods of the present fault reaction.
    reacting: u32,
}

impl Oracle {
    /// Control periods so far.
    pub fn periods(&self) -> u32 {
        self.summary.periods
    }

    /// The end of the run.
    pub fn summary(self) -> Summary {
        self.summary
    }

    /// A frame that the device receives.
    pub fn receive(&mut self, frame: &CanFrame) {
        let has = |byte: &u8| byte & ENABLE_OPERATION == ENABLE_OPERATION;
        self.may_drive |= frame.data().iter().any(has);
    }

    /// Checks a control period.
    ///
    /// # Panics
    /// If the device violates a requirement.
    pub fn check(&mut self, period: &Period) {
        let outputs = &period.outputs;
        self.check_power(period);
        self.check_transition(outputs);
        self.check_reaction_time(period);
        self.check_duty(period);
        self.check_angle(period);
        self.summary.periods += 1;
        self.summary.states.insert(outputs.state as u8);
        let fault = outputs.fault.map(|fault| fault as u8);
        self.summary.faults.extend(fault);
        self.before = Some(*outputs);
    }

    /// The motor is driven in the states that drive it, and never before a frame that commands one;
    /// in a fault and after a reset only against its back-EMF, which follows from the rate of the
    /// encoder in a period in which it is not measured.
    fn check_power(&mut self, period: &Period) {
        let outputs = &period.outputs;
        let Bridge::Driven(compare) = outputs.bridge else {
            return;
        };
        self.summary.driven += 1;
        assert!(self.may_drive, "driven without a command");
        let brakes = matches!(outputs.state, BoardState::Fault | BoardState::Initialising);
        let of_scan = |scan: Scan| measure::back_emf_mv(scan.leg_a, scan.leg_b, scan.supply);
        let turns = match period.samples.scan.and_then(of_scan) {
            Some(back_emf_mv) => back_emf_mv.cmp(&0),
            None => outputs.telemetry.rate.cmp(&Rate::ZERO),
        };
        let opposes = turns.is_ne() && compare.get().cmp(&0) == turns.reverse();
        let is_allowed = outputs.state.is_driving() || brakes && opposes;
        assert!(is_allowed, "driven in {:?}", outputs.state);
    }

    /// No state that drives the motor follows a fault, or the start, in one control period.
    fn check_transition(&self, outputs: &Outputs) {
        let Some(before) = self.before else { return };
        let is_off = matches!(before.state, BoardState::Fault | BoardState::Initialising);
        let is_allowed = !(is_off && outputs.state.is_driving());
        assert!(is_allowed, "{:?} after {:?}", outputs.state, before.state);
    }

    /// A fault reaction ends after its longest time.
    fn check_reaction_time(&mut self, period: &Period) {
        if period.outputs.state != BoardState::FaultReaction {
            self.reacting = 0;
            return;
        }
        self.reacting += 1;
        let longest_ms = period.settings.stop.quick_stop_ms as u32;
        let longest = (1_000 * longest_ms).div_ceil(CONTROL_PERIOD_US) + SLACK_PERIODS;
        let reacting = self.reacting;
        assert!(reacting <= longest, "{reacting} periods of {longest}");
    }

    /// The duty is within its limit.
    fn check_duty(&self, period: &Period) {
        let limit = period.duty_limit_pct;
        let duty = period.outputs.telemetry.duty.to_f64();
        if matches!(period.outputs.bridge, Bridge::Driven(_)) {
            assert!(duty.abs() <= limit + RESOLUTION_DEG, "{duty} of {limit} %");
        }
    }

    /// While the drive is enabled, an angle that changes does so by what the counts of valid words
    /// differ, since it changed last. A fault of the encoder discards the position.
    fn check_angle(&mut self, period: &Period) {
        let angle = period.outputs.telemetry.angle;
        let before = self.before.map(|before| before.telemetry.angle);
        let is_new = period.outputs.state != BoardState::Enabled
            || self.settings.replace(period.settings) != Some(period.settings);
        if is_new {
            self.accepted = None;
        }
        if is_new || before == Some(angle) {
            return;
        }
        let word = period.samples.encoder.and_then(|word| word.read().ok());
        let reading = word.expect("the angle changes only with a valid word");
        let (angle_deg, count) = (angle.to_f64(), i32::from(reading.count.get()));
        if let Some((last_deg, last)) = self.accepted.replace((angle_deg, count)) {
            let moved_deg = angle_deg - last_deg;
            let expected_deg = f64::from(count - last) * COUNT_DEG;
            // In either direction of mounting, and by any number of turns.
            let is_turns = |deg: f64| (deg - 360.0 * (deg / 360.0).round()).abs() < RESOLUTION_DEG;
            let is_honest =
                is_turns(moved_deg - expected_deg) || is_turns(moved_deg + expected_deg);
            assert!(is_honest, "{moved_deg} deg for {expected_deg} deg");
        }
    }
}
