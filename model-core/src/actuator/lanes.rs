//! Several boards at once around first-order motors, for campaigns: bit for bit the
//! [`ClosedLoop`](super::closed_loop::ClosedLoop) of each.

#![allow(
    clippy::needless_range_loop,
    reason = "each loop is over an index of many arrays"
)]

use core::array::from_fn;

use crate::{
    control::{cascade::Coefficients, lanes::CascadeLanes, units::Angle},
    parameter::ParameterError,
    plant::{
        PERIOD, PlantState,
        first_order::{
            FirstOrder,
            lanes::{Extremes, MotorLanes},
        },
    },
    sensors::encoder::{EncoderParameters, ideal_counts},
};

use super::{ModelKind, PlantKind, Settings};

/// Which ticks are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// Every one.
    All,
    /// The first of each PWM period.
    Edges,
}

/// `N` boards that follow one command.
#[derive(Debug, Clone)]
pub struct LoopLanes<const N: usize> {
    control: CascadeLanes<N>,
    motors: MotorLanes<N>,
    /// The extremes of what was seen.
    pub seen: Extremes<N>,
    /// The tick of the last control period that was seen last.
    last_tick: usize,
}

/// Whether these settings can be one of [`LoopLanes`]: the board with the mean voltage, without
/// rate limits, with an ideal encoder and a duty that the timer does not round.
pub fn is_plain(settings: &Settings) -> bool {
    let motor = &settings.first_order;
    (settings.model, settings.plant) == (ModelKind::Board, PlantKind::FirstOrder)
        && settings.pwm == crate::plant::Pwm::Average
        && motor.rate_limit_up_deg_s == f64::INFINITY
        && motor.rate_limit_down_deg_s == f64::INFINITY
        && settings.encoder == EncoderParameters::DEFAULT
        && settings.timer == super::closed_loop::TimerParameters::DEFAULT
}

impl<const N: usize> LoopLanes<N> {
    /// Boards at rest at zero; `None` unless all settings are [plain](is_plain).
    ///
    /// # Errors
    /// That of the first parameter which is out of its range.
    pub fn try_new(settings: [&Settings; N]) -> Result<Option<Self>, ParameterError> {
        if !settings.iter().all(|settings| is_plain(settings)) {
            return Ok(None);
        }
        let mut coefficients = [Coefficients::DEFAULT; N];
        for (lane, s) in settings.iter().enumerate() {
            coefficients[lane] = Coefficients::try_new(&s.control)?;
            FirstOrder::try_new(s.first_order, s.pwm)?;
        }
        let motor =
            |lane: usize| FirstOrder::of_checked(settings[lane].first_order, settings[lane].pwm);
        Ok(Self::of(&coefficients, from_fn(motor)))
    }

    fn of(coefficients: &[Coefficients; N], motors: [FirstOrder; N]) -> Option<Self> {
        Some(Self {
            control: CascadeLanes::new(coefficients),
            motors: MotorLanes::new(motors)?,
            seen: Extremes::default(),
            last_tick: 0,
        })
    }

    /// Passes a control period of which so many ticks are wanted, from 1 to 80.
    #[inline(always)]
    pub fn pass(&mut self, command: Angle, ticks: usize, see: Seen) {
        self.pass_each(&[command; N], ticks, see);
    }

    /// The same with a command for each board.
    #[inline(always)]
    pub fn pass_each(&mut self, commands: &[Angle; N], ticks: usize, see: Seen) {
        let counts = ideal_counts(&self.motors.states().angle_deg);
        let duty = self.control.step(&counts, commands);
        match see {
            Seen::All => {
                self.motors.pass::<true>(&duty, ticks, &mut self.seen);
                self.last_tick = ticks - 1;
            }
            Seen::Edges => {
                self.motors.pass::<false>(&duty, ticks, &mut self.seen);
                self.last_tick = (ticks - 1) / PERIOD * PERIOD;
            }
        }
    }

    /// The state of a board at the end of the last control period.
    pub fn state(&self, lane: usize) -> PlantState {
        self.motors.states().of(lane)
    }

    /// Its measured angle, deg, and its estimated rate, deg/s.
    pub fn measured(&self, lane: usize) -> (f64, f64) {
        let (angle, rate) = self.control.measured(lane);
        (angle.to_f64(), rate.to_f64())
    }

    /// Takes over a board with the same settings.
    pub fn keep(&mut self, other: &Self, lane: usize) {
        self.control.keep(&other.control, lane);
        self.motors.keep(&other.motors, lane);
    }

    /// The state of a board at the tick that was seen last.
    pub fn last(&self, lane: usize) -> PlantState {
        self.motors.at(lane, self.last_tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::CONTROL_PERIOD_TICKS;
    use crate::{actuator::closed_loop::ClosedLoop, control::units::angle, plant::Plant};
    use proptest::{prelude::*, sample::Index};
    use std::vec::Vec;

    const LANES: usize = 3;
    const EDGES: usize = CONTROL_PERIOD_TICKS as usize / PERIOD;

    /// Settings with some of the parameters of control and motor anywhere in a useful range.
    fn settings() -> impl Strategy<Value = Settings> {
        // Name, least and greatest value.
        const RANGES: [(&str, f64, f64); 17] = [
            ("position_gain", 0.0, 40.0),
            ("proportional_gain", 0.0, 6.0),
            ("integral_gain", 0.0, 100.0),
            ("anti_windup_gain", 0.0, 50.0),
            ("feed_forward_gain", 0.0, 2.0),
            ("rate_filter", 0.01, 1.0),
            ("duty_limit_pct", 5.0, 100.0),
            ("duty_slew_pct_s", 50.0, 10_000.0),
            ("rate_command_limit_up_deg_s", 5.0, 400.0),
            ("rate_command_limit_down_deg_s", 5.0, 400.0),
            ("position_min_deg", -150.0, 0.0),
            ("position_max_deg", 0.0, 150.0),
            ("encoder_zero_deg", -180.0, 180.0),
            ("motor_gain_up", 0.1, 10.0),
            ("motor_gain_down", 0.1, 10.0),
            ("motor_time_constant_s", 1e-3, 1.0),
            ("position_limit_deg", 1.0, 200.0),
        ];
        let changes = proptest::collection::vec((0..RANGES.len(), 0.0..1.0), 0..8);
        (changes, any::<bool>()).prop_map(|(changes, is_reversed)| {
            let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
            for (index, share) in changes {
                let (name, least, greatest) = RANGES[index];
                let value = least + share * (greatest - least);
                settings.set(name, value).unwrap();
            }
            if is_reversed {
                settings.set("encoder_direction", -1.0).unwrap();
            }
            settings
        })
    }

    /// The same periods in single boards: every tick that is seen, in order.
    fn single(settings: &Settings, commands: &[Angle], last: usize, see: Seen) -> Vec<PlantState> {
        let motor = FirstOrder::try_new(settings.first_order, settings.pwm).unwrap();
        let mut board: ClosedLoop<FirstOrder> = settings.around(motor).unwrap();
        let mut seen = Vec::new();
        for (k, command) in commands.iter().enumerate() {
            let ticks = if k + 1 == commands.len() { last } else { 80 };
            for edge in 0..EDGES {
                board.start_period(|_| *command);
                let wanted = ticks.saturating_sub(edge * PERIOD).min(PERIOD);
                let shown = if see == Seen::All {
                    wanted
                } else {
                    wanted.min(1)
                };
                seen.extend((0..shown).map(|tick| board.plant.at(tick)));
            }
        }
        seen
    }

    fn ends(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
        let least = values.clone().fold(f64::INFINITY, f64::min);
        (least, values.fold(f64::NEG_INFINITY, f64::max))
    }

    fn compare<const N: usize>(
        settings: [&Settings; N],
        commands: &[Angle],
        last: usize,
        see: Seen,
    ) {
        let mut lanes = LoopLanes::<N>::try_new(settings)
            .unwrap()
            .expect("plain settings");
        for (k, command) in commands.iter().enumerate() {
            let ticks = if k + 1 == commands.len() { last } else { 80 };
            lanes.pass(*command, ticks, see);
        }
        for (lane, settings) in settings.iter().enumerate() {
            let states = single(settings, commands, last, see);
            let angle = ends(states.iter().map(|state| state.angle_deg));
            let rate = ends(states.iter().map(|state| state.rate_deg_s));
            let (least, greatest) = (lanes.seen.least.of(lane), lanes.seen.greatest.of(lane));
            assert_eq!((least.angle_deg, greatest.angle_deg), angle);
            assert_eq!((least.rate_deg_s, greatest.rate_deg_s), rate);
            assert_eq!(lanes.last(lane), *states.last().unwrap());
        }
    }

    proptest! {
        #[test]
        fn the_extremes_and_the_end_are_those_of_single_boards(
            boards in proptest::collection::vec(settings(), LANES),
            levels in proptest::collection::vec(-200.0..200.0, 1..12),
            hold in 1_usize..120,
            last in 1_usize..=80,
            sees_all: bool,
            only: Index,
        ) {
            let commands = levels.iter().flat_map(|level| core::iter::repeat_n(angle(*level), hold));
            let commands: Vec<_> = commands.collect();
            let see = if sees_all { Seen::All } else { Seen::Edges };
            let three: [&Settings; LANES] = from_fn(|lane| &boards[lane]);
            compare(three, &commands, last, see);
            compare([only.get(&boards)], &commands, last, see);
        }
    }

    #[test]
    fn a_board_that_comes_to_rest_is_seen_to_the_last_tick() {
        let settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
        for level in [0.0, 0.02, 30.0, -30.0] {
            compare([&settings], &[angle(level); 1500], 80, Seen::All);
        }
    }

    #[test]
    fn what_the_lanes_do_not_compute_is_left_to_single_boards() {
        for (name, value) in [
            ("rate_limit_up_deg_s", 100.0),
            ("encoder_noise_deg", 0.03),
            ("timer_counts", 1.0),
        ] {
            let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
            settings.set(name, value).unwrap();
            assert!(LoopLanes::<1>::try_new([&settings]).unwrap().is_none());
        }
    }
}
