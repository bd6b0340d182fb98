//! The equations of a continuous model between its events.
//!
//! `model-core` has the derivatives. Here are the limits: at a hard stop, or with a rate integrator
//! at its limit, a state rests until its derivative points inward, and where a saturation begins or
//! ends the derivative has a kink. Each of them has an event indicator, which is positive between
//! events.

use model_core::actuator::{ModelKind, Settings};
use model_core::models::black_box_1::BlackBox1Parameters;
use model_core::models::black_box_2::{BlackBox2Parameters, RateLimitForm};
use model_core::models::grey_box::{Demand, GreyBoxParameters};
use serde::{Deserialize, Serialize};

/// Angle, deg, rate, deg/s, integrator of the rate loop, %; a model has the first of them.
pub type State = [f64; 3];

/// Distance beyond a limit at which its event takes place, in the unit of the limited quantity: a
/// host detects the crossing of zero, not the arrival.
const BEYOND: f64 = 1e-9;

/// The most kinks of a model.
const MOST_KINKS: usize = 5;

/// The value of an indicator whose event cannot happen.
const NEVER: f64 = 1.0;

/// Where a limited state is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Side {
    /// Between its limits.
    #[default]
    Free,
    /// At the upper limit, and driven outward.
    High,
    /// At the lower limit, and driven outward.
    Low,
}

/// On which side of its limits a model is.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Sides {
    /// The angle, between the hard stops.
    stop: Side,
    /// A limited integrator of the rate.
    rate: Side,
    /// Whether each kink is passed.
    beyond: [bool; MOST_KINKS],
}

/// A continuous model with its parameters.
#[derive(Debug, Clone, Copy)]
pub enum Equations {
    /// Black box 1.
    BlackBox1(BlackBox1Parameters),
    /// Black box 2.
    BlackBox2(BlackBox2Parameters),
    /// The grey box.
    GreyBox(GreyBoxParameters),
}

impl Equations {
    /// The equations of these settings; `None` for the board, which is not continuous.
    pub fn of(settings: &Settings) -> Option<Self> {
        match settings.model {
            ModelKind::BlackBox1 => Some(Self::BlackBox1(settings.black_box_1)),
            ModelKind::BlackBox2 => Some(Self::BlackBox2(settings.black_box_2)),
            ModelKind::GreyBox => Some(Self::GreyBox(settings.grey_box)),
            ModelKind::Board => None,
        }
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        match self {
            Self::BlackBox1(_) => 1,
            Self::BlackBox2(_) => 2,
            Self::GreyBox(_) => 3,
        }
    }

    /// Number of event indicators: those of the stops, then of a limited integrator or of kinks.
    pub fn indicator_count(&self) -> usize {
        match self {
            Self::BlackBox1(_) | Self::BlackBox2(_) => 4,
            Self::GreyBox(_) => 7,
        }
    }

    fn position_limit_deg(&self) -> f64 {
        match self {
            Self::BlackBox1(p) => p.position_limit_deg,
            Self::BlackBox2(p) => p.position_limit_deg,
            Self::GreyBox(p) => p.position_limit_deg,
        }
    }

    /// The limits of a limited integrator of the rate, if the model has one.
    fn rate_integrator_limits(&self) -> Option<(f64, f64)> {
        match self {
            Self::BlackBox2(p) if p.form() == RateLimitForm::LimitedIntegrator => {
                Some((p.rate_limit_up_deg_s, -p.rate_limit_down_deg_s))
            }
            _ => None,
        }
    }

    /// The derivative without stops and without a limit of the integrator.
    fn free(&self, command: Demand, state: &State) -> State {
        let [angle, rate, _] = *state;
        let target = |gain: f64, offset: f64| match command {
            Demand::Angle(command_deg) => gain * command_deg + offset,
            // A black box is commanded in an angle alone.
            Demand::Rate(_) | Demand::Duty(_) => offset,
        };
        match self {
            Self::BlackBox1(p) => [p.rate_deg_s(target(p.gain, p.offset_deg), angle), 0.0, 0.0],
            Self::BlackBox2(p) => {
                let form = match p.form() {
                    // Within its limits it is that of a limited feedback.
                    RateLimitForm::LimitedIntegrator => RateLimitForm::LimitedFeedback,
                    form => form,
                };
                let target_deg = target(p.gain, p.offset_deg);
                let [angle, rate] = p.derivative(form, target_deg, [angle, rate]);
                [angle, rate, 0.0]
            }
            Self::GreyBox(p) => {
                let [angle, rate, integral] = p.derivative(command, *state);
                match command {
                    // The loops are open: the integrator remains empty.
                    Demand::Duty(_) => [angle, rate, 0.0],
                    _ => [angle, rate, integral],
                }
            }
        }
    }

    /// The outward drive at a hard stop: the rate of a model without inertia, otherwise the
    /// acceleration.
    fn drive(&self, free: &State) -> f64 {
        match self {
            Self::BlackBox1(_) => free[0],
            Self::BlackBox2(_) | Self::GreyBox(_) => free[1],
        }
    }

    /// How far each kink is passed; below zero it is ahead.
    fn kinks(&self, command: Demand, state: &State) -> Vec<f64> {
        let [angle, rate, _] = *state;
        match (self, command) {
            (Self::BlackBox1(p), Demand::Angle(command_deg)) => {
                let raw = p.unlimited_rate_deg_s(p.target_deg(command_deg), angle);
                vec![raw - p.rate_limit_up_deg_s, -p.rate_limit_down_deg_s - raw]
            }
            (Self::BlackBox1(_), _) => vec![f64::NEG_INFINITY; 2],
            (Self::BlackBox2(_), _) if self.rate_integrator_limits().is_some() => Vec::new(),
            (Self::BlackBox2(p), _) => vec![
                rate - p.rate_limit_up_deg_s,
                -p.rate_limit_down_deg_s - rate,
            ],
            (Self::GreyBox(p), _) => {
                let control = p.control(command, *state);
                vec![
                    rate - p.rate_limit_up_deg_s,
                    -p.rate_limit_down_deg_s - rate,
                    control.demand_pct - p.duty_limit_pct,
                    -p.duty_limit_pct - control.demand_pct,
                    // The motor has another gain.
                    control.demand_pct,
                ]
            }
        }
    }

    /// The derivative of the states.
    pub fn derivative(&self, command: Demand, state: &State, sides: &Sides) -> State {
        let mut derivative = self.free(command, state);
        if sides.rate != Side::Free {
            derivative[1] = 0.0;
        }
        if sides.stop != Side::Free {
            derivative[0] = 0.0;
            derivative[1] = 0.0;
        }
        derivative
    }

    /// The event indicators.
    pub fn indicators(&self, command: Demand, state: &State, sides: &Sides) -> Vec<f64> {
        let free = self.free(command, state);
        let mut all = Vec::with_capacity(self.indicator_count());
        let limit_deg = self.position_limit_deg();
        let of_limit = |side: Side, at: Side, outward: f64, excess: f64| {
            if side == at {
                BEYOND + outward
            } else {
                ahead(excess)
            }
        };
        let drive = self.drive(&free);
        all.push(of_limit(
            sides.stop,
            Side::High,
            drive,
            state[0] - limit_deg,
        ));
        all.push(of_limit(
            sides.stop,
            Side::Low,
            -drive,
            -limit_deg - state[0],
        ));
        if let Some((up, down)) = self.rate_integrator_limits() {
            all.push(of_limit(sides.rate, Side::High, free[1], state[1] - up));
            all.push(of_limit(sides.rate, Side::Low, -free[1], down - state[1]));
        }
        let kinks = self.kinks(command, state).into_iter().zip(sides.beyond);
        all.extend(kinks.map(|(excess, is_beyond)| {
            if is_beyond {
                BEYOND + excess
            } else {
                ahead(excess)
            }
        }));
        all
    }

    /// Takes each limited state to its side at an event.
    pub fn settle(&self, command: Demand, state: &mut State, sides: &mut Sides) {
        if let (Self::GreyBox(_), Demand::Duty(_)) = (self, command) {
            state[2] = 0.0;
        }
        let limit_deg = self.position_limit_deg();
        let stops = (limit_deg, -limit_deg);
        state[0] = state[0].min(limit_deg).max(-limit_deg);
        let has_inertia = self.states() > 1;
        if has_inertia && side(state[0], stops, state[1]) != Side::Free {
            // It arrives with its rate.
            state[1] = 0.0;
        }
        let drive = self.drive(&self.free(command, state));
        sides.stop = match has_inertia && state[1] != 0.0 {
            true => Side::Free,
            false => side(state[0], stops, drive),
        };
        if let Some((up, down)) = self.rate_integrator_limits() {
            state[1] = state[1].min(up).max(down);
            let acceleration = self.free(command, state)[1];
            sides.rate = match sides.stop {
                Side::Free => side(state[1], (up, down), acceleration),
                Side::High | Side::Low => Side::Free,
            };
        }
        for (beyond, excess) in sides.beyond.iter_mut().zip(self.kinks(command, state)) {
            *beyond = excess > 0.0;
        }
    }

    /// Rate, deg/s, and duty, %, of the outputs.
    pub fn rate_and_duty(&self, command: Demand, state: &State, sides: &Sides) -> [f64; 2] {
        match self {
            Self::BlackBox1(_) => [self.derivative(command, state, sides)[0], 0.0],
            Self::BlackBox2(p) => [p.limited(state[1]), 0.0],
            Self::GreyBox(p) => {
                let control = p.control(command, *state);
                [control.limited_rate_deg_s, control.duty_pct]
            }
        }
    }

    /// The duty before its limit, of a closed rate loop; 0 without one.
    pub fn demand_pct(&self, command: Demand, state: &State) -> f64 {
        match (self, command) {
            (_, Demand::Duty(_)) => 0.0,
            (Self::GreyBox(p), _) => p.control(command, *state).demand_pct,
            _ => 0.0,
        }
    }
}

/// The indicator of a limit that is ahead.
fn ahead(excess: f64) -> f64 {
    if excess.is_finite() {
        BEYOND - excess
    } else {
        NEVER
    }
}

/// The side of a value with these limits that moves or is driven in a direction.
fn side(value: f64, (high, low): (f64, f64), outward: f64) -> Side {
    if value >= high && outward > 0.0 {
        Side::High
    } else if value <= low && outward < 0.0 {
        Side::Low
    } else {
        Side::Free
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::actuator::PlantKind;

    fn equations(model: ModelKind, set: &[(&str, f64)]) -> Equations {
        let mut settings = Settings::new(model, PlantKind::FirstOrder);
        for (name, value) in set {
            settings.set(name, *value).unwrap();
        }
        Equations::of(&settings).unwrap()
    }

    const MODELS: [ModelKind; 3] = [
        ModelKind::BlackBox1,
        ModelKind::BlackBox2,
        ModelKind::GreyBox,
    ];

    #[test]
    fn a_stop_holds_the_angle_until_the_drive_points_inward() {
        for model in MODELS {
            let equations = equations(model, &[]);
            let (mut state, mut sides) = ([180.0 + 1e-9, 50.0, 0.0], Sides::default());
            if model == ModelKind::BlackBox1 {
                state[1] = 0.0;
            }
            equations.settle(Demand::Angle(200.0), &mut state, &mut sides);
            assert_eq!((state[0], state[1], sides.stop), (180.0, 0.0, Side::High));
            let derivative = equations.derivative(Demand::Angle(200.0), &state, &sides);
            assert_eq!([derivative[0], derivative[1]], [0.0; 2]);
            let released = Demand::Angle(170.0);
            let indicator = equations.indicators(released, &state, &sides)[0];
            assert!(indicator < 0.0, "{model:?} {indicator}");
            equations.settle(released, &mut state, &mut sides);
            assert_eq!(sides.stop, Side::Free, "{model:?}");
            let derivative = equations.derivative(released, &state, &sides);
            assert!(derivative[0].min(derivative[1]) < 0.0);
        }
    }

    #[test]
    fn a_limited_integrator_rests_at_its_limit_until_it_is_decelerated() {
        let equations = equations(ModelKind::BlackBox2, &[]);
        let (mut state, mut sides) = ([0.0, 240.0, 0.0], Sides::default());
        equations.settle(Demand::Angle(90.0), &mut state, &mut sides);
        assert_eq!(sides.rate, Side::High);
        let derivative = equations.derivative(Demand::Angle(90.0), &state, &sides);
        assert_eq!(derivative, [240.0, 0.0, 0.0]);
        // A (90 - theta) = B 240 at 75.6 deg.
        for (angle_deg, is_due) in [(75.59, false), (75.61, true)] {
            state[0] = angle_deg;
            let indicator = equations.indicators(Demand::Angle(90.0), &state, &sides)[2];
            assert_eq!(indicator < 0.0, is_due, "{angle_deg}");
        }
    }

    #[test]
    fn every_indicator_is_positive_after_its_event_and_their_number_is_constant() {
        for model in MODELS {
            for form in [0.0, 1.0, 2.0] {
                let set: &[(&str, f64)] = match model {
                    ModelKind::BlackBox2 => &[("rate_limit_form", form)],
                    ModelKind::GreyBox => &[("rate_limit_up_deg_s", 100.0)],
                    _ => &[],
                };
                let equations = equations(model, set);
                for angle in [-180.0, -180.0 - 1e-9, 0.0, 20.0, 180.0] {
                    for rate in [-400.0, -350.0, 0.0, 100.0, 240.0, 241.0] {
                        for command in [-200.0, -1.0, 0.0, 20.0, 200.0] {
                            let demand = Demand::Angle(command);
                            let (mut state, mut sides) = ([angle, rate, 10.0], Sides::default());
                            equations.settle(demand, &mut state, &mut sides);
                            let all = equations.indicators(demand, &state, &sides);
                            assert_eq!(all.len(), equations.indicator_count());
                            assert!(all.iter().all(|z| *z > 0.0), "{model:?} {state:?} {all:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn the_derivative_without_a_limit_is_that_of_the_model() {
        // p (c - theta); A (c - theta) - B w; (K u - w)/tau with u = Kp (P (c - theta) - w) + x.
        let state = [1.0, 2.0, 3.0];
        let of =
            |model| equations(model, &[]).derivative(Demand::Angle(2.0), &state, &Sides::default());
        assert!((of(ModelKind::BlackBox1)[0] - 30.0).abs() < 1e-12);
        assert!((of(ModelKind::BlackBox2)[1] - (900.0 - 108.0)).abs() < 1e-9);
        let duty = 10.0 / 7.586 * (8.0 - 2.0) + 3.0;
        assert!((of(ModelKind::GreyBox)[1] - (2.836 * duty - 2.0) * 7.586).abs() < 1e-9);
        assert!((of(ModelKind::GreyBox)[2] - 60.0).abs() < 1e-9);
    }
}
