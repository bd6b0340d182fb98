//! Several drivetrains at once, bit for bit those of
//! [`SteppedDrivetrain`](super::stepped::SteppedDrivetrain).
//!
//! A step of a drivetrain waits for its own results most of the time; drivetrains side by side fill
//! that time, and vectors take several in one instruction.

#![allow(
    clippy::needless_range_loop,
    reason = "each loop is over an index of many arrays"
)]

use core::array::from_fn;

use super::gear_train::lanes::{Chain, TrainLanes};
use super::{Drivetrain, electrical, or_rest, state};
use crate::actuator::{PlantKind, Settings};
use crate::parameter::ParameterError;
use crate::plant::lanes::{Extremes, PlantLanes, STEPS, States, float, greater_of, lesser_of};
use crate::plant::{PERIOD, PlantState, Pwm};
use crate::time::CONTROL_PERIOD_TICKS;

/// What drivetrains have to have in common to be computed side by side, and the steps of a tick,
/// which need not be the same but had better be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Likeness {
    chain: Chain,
    steps: u32,
}

impl Likeness {
    /// That of the drivetrain of these settings; `None` if it has to be computed alone: the
    /// parameters are refused, the bridge switches, friction is other than M1, or there is a
    /// pendulum.
    pub fn of(settings: &Settings) -> Option<Self> {
        let drivetrain = Drivetrain::try_new(&settings.drivetrain).ok()?;
        let likeness = drivetrain.likeness()?;
        (settings.pwm == Pwm::Average).then_some(likeness)
    }
}

impl Drivetrain {
    fn likeness(&self) -> Option<Likeness> {
        Some(Likeness {
            chain: self.train.chain(&self.load)?,
            steps: self.steps_of_tick.count,
        })
    }
}

/// Drivetrains that are driven by the mean voltage, of one chain.
#[derive(Debug, Clone)]
pub struct DrivetrainLanes<const N: usize> {
    chain: Chain,
    /// Steps of a tick.
    steps: [u32; N],
    windings: Windings<N>,
    train: TrainLanes<N>,
    supply_v: [f64; N],
    /// In force during the first PWM period of the last control period, and since then.
    duty: [[i64; N]; 2],
    /// At the end of the last control period.
    end: States<N>,
    /// What was seen last.
    last: States<N>,
}

/// The windings, of which the bridge drives each with a voltage.
#[derive(Debug, Clone)]
struct Windings<const N: usize> {
    current_a: [f64; N],
    constant_nm_a: [f64; N],
    left: [f64; N],
    gain_s: [f64; N],
    mean_left: [f64; N],
    mean_gain_s: [f64; N],
}

impl<const N: usize> Windings<N> {
    /// Advances a winding by a step, if it is taken; returns the torque of its motor at the output,
    /// Nm.
    #[inline(always)]
    fn advance(&mut self, lane: usize, terminal_v: f64, rate_rad_s: f64, is_taken: bool) -> f64 {
        let step = electrical::Step {
            step_s: 0.0,
            left: self.left[lane],
            gain_s: self.gain_s[lane],
            mean_left: self.mean_left[lane],
            mean_gain_s: self.mean_gain_s[lane],
        };
        let (old_a, constant_nm_a) = (self.current_a[lane], self.constant_nm_a[lane]);
        let mut current_a = old_a;
        let mean_a = step.advance(&mut current_a, terminal_v - constant_nm_a * rate_rad_s);
        self.current_a[lane] = if is_taken { current_a } else { old_a };
        constant_nm_a * mean_a
    }
}

impl<const N: usize> DrivetrainLanes<N> {
    /// These drivetrains, driven by the mean voltage; `None` unless they have one chain.
    fn new(drivetrains: &[Drivetrain; N]) -> Option<Self> {
        let chain = drivetrains.first()?.likeness()?.chain;
        let is_alike = |d: &Drivetrain| d.likeness().is_some_and(|own| own.chain == chain);
        if !drivetrains.iter().all(is_alike) {
            return None;
        }
        let of = |get: fn(&Drivetrain) -> f64| from_fn(|lane| get(&drivetrains[lane]));
        let windings = Windings {
            current_a: of(|d| d.winding.current_a),
            constant_nm_a: of(|d| d.constant_nm_a),
            left: of(|d| d.steps_of_tick.electrical.left),
            gain_s: of(|d| d.steps_of_tick.electrical.gain_s),
            mean_left: of(|d| d.steps_of_tick.electrical.mean_left),
            mean_gain_s: of(|d| d.steps_of_tick.electrical.mean_gain_s),
        };
        let train = drivetrains.each_ref();
        let train = TrainLanes::new(train.map(|d| (&d.train, &d.load, d.steps_of_tick.step_s)));
        let mut end = States::all(0.0);
        for lane in 0..N {
            end.set(lane, state(drivetrains[lane].train.output()));
        }
        Some(Self {
            chain,
            steps: from_fn(|lane| drivetrains[lane].steps_of_tick.count),
            windings,
            train,
            supply_v: of(|d| d.supply_v),
            duty: [[0; N]; 2],
            end,
            last: end,
        })
    }

    /// The control period of trains with so many bodies.
    #[inline(always)]
    fn run<const ALL: bool, const COUNT: usize, const OUTPUT: usize>(
        &mut self,
        ticks: usize,
        seen: &mut Extremes<N>,
    ) {
        let least = self.steps.iter().copied().min().unwrap_or(0);
        let most = self.steps.iter().copied().max().unwrap_or(0);
        let mut level_v = [0.0; N];
        for tick in 0..CONTROL_PERIOD_TICKS as usize {
            if tick % PERIOD == 0 {
                self.settle();
                let duty = &self.duty[usize::from(tick > 0)];
                for lane in 0..N {
                    let share = float(duty[lane]) / STEPS / 100.0;
                    level_v[lane] = self.supply_v[lane] * share;
                }
            }
            if tick < ticks && (ALL || tick % PERIOD == 0) {
                self.see::<OUTPUT>(seen);
            }
            for _ in 0..least {
                for lane in 0..N {
                    self.advance::<COUNT, OUTPUT>(lane, level_v[lane], true);
                }
            }
            for step in least..most {
                for lane in 0..N {
                    let is_taken = step < self.steps[lane];
                    self.advance::<COUNT, OUTPUT>(lane, level_v[lane], is_taken);
                }
            }
        }
        for lane in 0..N {
            self.end.set(lane, state(self.train.output::<OUTPUT>(lane)));
        }
    }

    /// As [`Drivetrain::settle`].
    fn settle(&mut self) {
        for current_a in &mut self.windings.current_a {
            *current_a = or_rest(*current_a);
        }
        self.train.settle();
    }

    #[inline(always)]
    fn advance<const COUNT: usize, const OUTPUT: usize>(
        &mut self,
        lane: usize,
        level_v: f64,
        is_taken: bool,
    ) {
        let rate_rad_s = self.train.motor_rad_s(lane);
        let motor_nm = self.windings.advance(lane, level_v, rate_rad_s, is_taken);
        self.train
            .advance::<COUNT, OUTPUT>(lane, motor_nm, is_taken);
    }

    /// Includes the present states.
    #[inline(always)]
    fn see<const OUTPUT: usize>(&mut self, seen: &mut Extremes<N>) {
        for lane in 0..N {
            let now = state(self.train.output::<OUTPUT>(lane));
            let (least, greatest) = (seen.least.of(lane), seen.greatest.of(lane));
            seen.least.set(lane, lesser_of(now, least));
            seen.greatest.set(lane, greater_of(now, greatest));
            self.last.set(lane, now);
        }
    }
}

impl<const N: usize> PlantLanes<N> for DrivetrainLanes<N> {
    const KIND: PlantKind = PlantKind::Drivetrain;

    fn try_new(settings: [&Settings; N]) -> Result<Option<Self>, ParameterError> {
        for s in settings {
            s.drivetrain.check()?;
        }
        if settings.iter().any(|s| s.pwm != Pwm::Average) {
            return Ok(None);
        }
        let drivetrains = settings.map(|s| Drivetrain::of_checked(&s.drivetrain));
        Ok(Self::new(&drivetrains))
    }

    fn states(&self) -> &States<N> {
        &self.end
    }

    #[inline(always)]
    fn pass<const ALL: bool>(&mut self, duty: &[i64; N], ticks: usize, seen: &mut Extremes<N>) {
        self.duty = [self.duty[1], *duty];
        match self.chain {
            Chain::Three => self.run::<ALL, 3, 1>(ticks, seen),
            Chain::RigidShaft => self.run::<ALL, 2, 1>(ticks, seen),
            Chain::RigidGears => self.run::<ALL, 2, 0>(ticks, seen),
            Chain::Rigid => self.run::<ALL, 1, 0>(ticks, seen),
        }
    }

    fn last_seen(&self, lane: usize) -> PlantState {
        self.last.of(lane)
    }

    fn keep(&mut self, other: &Self, lane: usize) {
        self.windings.current_a[lane] = other.windings.current_a[lane];
        self.train.keep(&other.train, lane);
        for (duty, other) in self.duty.iter_mut().zip(&other.duty) {
            duty[lane] = other[lane];
        }
        self.end.set(lane, other.end.of(lane));
        self.last.set(lane, other.last.of(lane));
    }
}
