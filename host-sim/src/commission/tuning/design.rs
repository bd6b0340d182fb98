//! Gains from the identified motor: the fastest rate loop whose sampled position loop has its
//! margins for every motor within the standard errors.
//!
//! ```text
//! J w' = k gd d - (b + k gb) w        K = k gd/(b + k gb)        tau = J/(b + k gb)
//! ```
//!
//! `gd` is the mean current by duty and `gb` that by back-EMF, with the dead times and the window
//! of the bridge. Coulomb friction is left out: it adds damping, and a loop is less stable without.

use std::f64::consts::TAU;

use model_core::control::parameters::ControlParameters;
use model_core::control::pwm_timer::PWM_COUNTS;

use super::super::Estimate;
use super::super::winding::{Driven, Winding};
use super::Margins;
use super::response::{LINES, Multisine};
use crate::analysis::frequency::bisect;
use crate::analysis::linear_models::{Loop, Motor, Timing};
use crate::tune::{self, Goal, InnerLoop, TuneRequest, Tuning};

/// Least phase margin of all motors, deg.
pub const LEAST_PHASE_DEG: f64 = 50.0;

/// Least gain margin of all motors, dB: a factor of three.
pub const LEAST_GAIN_DB: f64 = 9.5;

/// Standard errors from the middle of an interval to its ends.
pub const REACH: f64 = 3.0;

/// Position gain as a share of the bandwidth of the rate loop: critical damping.
const SHARE: f64 = 0.25;

/// Bandwidths of the rate loop that are searched, rad/s: those of gains within their ranges.
const BANDWIDTHS_RAD_S: (f64, f64) = (0.5, 500.0);

/// Greatest value of a multisine by its rms.
const CREST: f64 = 1.9;

/// Duty and back-EMF at which the current is linearised: half of the range, and a volt.
const HALF_PCT: f64 = 50.0;
const BACK_EMF_V: f64 = 1.0;

/// What the loop depends on.
#[derive(Debug, Clone, Copy)]
pub struct Identified {
    /// Resistance at the present temperature, ohm.
    pub resistance_ohm: Estimate,
    /// Inductance, H.
    pub inductance_h: f64,
    /// Back-EMF by rate of the output, V s/rad.
    pub v_s_rad: Estimate,
    /// Inertia at the output, kg m^2.
    pub inertia_kg_m2: Estimate,
    /// Viscous friction at the output, Nm s/rad.
    pub viscous_nm_s: Estimate,
    /// Delay, s.
    pub delay_s: Estimate,
    /// Supply, V: its middle, and the distance of its ends as three standard errors.
    pub supply_v: Estimate,
    /// Limit of the mean current, A.
    pub most_a: f64,
}

/// Greatest duty of the excitations, %: below the limit of the duty.
const DUTY_PCT: f64 = 70.0;

impl Identified {
    /// Sum of the duties of the lines of the sweep, and duty of a step, %: at rest within the limit
    /// of the current. A motor that is driven on takes less.
    pub fn duty_pct(&self) -> f64 {
        let most_v = self.most_a * self.resistance_ohm.value;
        DUTY_PCT.min(100.0 * most_v / self.supply_v.value)
    }

    /// The motor, each parameter at its value plus so many standard errors: of resistance, back-EMF
    /// by rate, inertia, viscous friction and supply.
    pub fn motor(&self, errors: [f64; 5]) -> Motor {
        let at = |of: Estimate, errors: f64| of.value + errors * of.standard_error;
        let winding = Winding {
            resistance_ohm: at(self.resistance_ohm, errors[0]),
            inductance_h: self.inductance_h,
        };
        let v_s_rad = at(self.v_s_rad, errors[1]);
        let inertia_kg_m2 = at(self.inertia_kg_m2, errors[2]);
        let viscous_nm_s = at(self.viscous_nm_s, errors[3]).max(0.0);
        let driven = Driven {
            compare: PWM_COUNTS / 2,
            supply_v: at(self.supply_v, errors[4]),
            back_emf_v: 0.0,
        };
        let turning = Driven {
            back_emf_v: BACK_EMF_V,
            ..driven
        };
        let stalled_a = winding.current(driven).mean_a;
        let opposed_a = stalled_a - winding.current(turning).mean_a;
        let damping_nm_s = viscous_nm_s + v_s_rad * v_s_rad * opposed_a / BACK_EMF_V;
        Motor {
            motor_gain: (v_s_rad * stalled_a / HALF_PCT / damping_nm_s).to_degrees(),
            motor_time_constant_s: inertia_kg_m2 / damping_nm_s,
        }
    }

    /// The motors at the corners of the least rectangle of gain and time constant that contains
    /// all of the box, and the middle one.
    fn motors(&self) -> [Motor; 5] {
        let middle = self.motor([0.0; 5]);
        let corner =
            |bits: u32| std::array::from_fn(|i| if bits >> i & 1 == 0 { -REACH } else { REACH });
        let (mut low, mut high) = (middle, middle);
        for motor in (0..32).map(|bits| self.motor(corner(bits))) {
            low.motor_gain = low.motor_gain.min(motor.motor_gain);
            high.motor_gain = high.motor_gain.max(motor.motor_gain);
            let tau_s = motor.motor_time_constant_s;
            low.motor_time_constant_s = low.motor_time_constant_s.min(tau_s);
            high.motor_time_constant_s = high.motor_time_constant_s.max(tau_s);
        }
        let slow = |motor| Motor {
            motor_time_constant_s: high.motor_time_constant_s,
            ..motor
        };
        let fast = |motor| Motor {
            motor_time_constant_s: low.motor_time_constant_s,
            ..motor
        };
        [middle, slow(low), fast(low), slow(high), fast(high)]
    }

    /// The timing with the delay at its value plus so many standard errors.
    pub fn timing(&self, errors: f64) -> Timing {
        Timing {
            duty_delay_s: (self.delay_s.value + errors * self.delay_s.standard_error).max(0.0),
            ..Timing::default()
        }
    }

    /// Least margins of the box and highest crossing; `None` if a loop is unstable. A longer delay
    /// decreases both margins, and along each side of the rectangle the least are at its ends.
    pub fn least(&self, control: &ControlParameters) -> Option<Margins> {
        let timing = self.timing(REACH);
        let motors = self.motors();
        let margins = motors
            .iter()
            .map(|motor| Margins::of(motor, control, &timing));
        let least = |a: Margins, b: Margins| Margins {
            phase_deg: a.phase_deg.min(b.phase_deg),
            gain_db: a.gain_db.min(b.gain_db),
            crossing_hz: a.crossing_hz.max(b.crossing_hz),
        };
        margins.reduce(|a, b| a.zip(b).map(|(a, b)| least(a, b)))?
    }

    /// Greatest duty of a multisine by the amplitude of its lines, %/deg.
    pub fn duty_by_command(&self, control: &ControlParameters, sine: &Multisine) -> f64 {
        let motor = self.motor([0.0; 5]);
        let Ok(servo) = Loop::sampled(&motor, control, &self.timing(0.0)) else {
            return f64::INFINITY;
        };
        let of_line = |line| -> f64 {
            let hz = sine.line_hz(line);
            let rad_s = TAU * hz;
            let steps = rad_s * (rad_s * motor.motor_time_constant_s).hypot(1.0);
            servo.closed.at(hz).norm() * steps / motor.motor_gain
        };
        let squares: f64 = (0..LINES).map(|line| of_line(line).powi(2)).sum();
        CREST * (squares / 2.0).sqrt()
    }

    /// The request for a bandwidth of the rate loop, with these other parameters of the loop.
    fn request(&self, control: &ControlParameters, inner_bandwidth_rad_s: f64) -> TuneRequest {
        TuneRequest {
            motor: self.motor([0.0; 5]),
            timing: self.timing(0.0),
            control: *control,
            goal: Goal::Inner(InnerLoop {
                inner_bandwidth_rad_s,
                position_share: SHARE,
            }),
            ..TuneRequest::default()
        }
    }

    /// The fastest loop with the margins over the box and without a warning of [`tune::tune`]: of
    /// motors that differ by more, and of the step of the duty by a count of the encoder. `None` if
    /// no gains have them.
    pub fn fastest(&self, control: &ControlParameters) -> Option<Tuning> {
        let tuning = |rad_s| tune::tune(&self.request(control, rad_s)).ok();
        let holds = |rad_s: f64| {
            let found = tuning(rad_s).filter(|tuning| tuning.warnings.is_empty());
            found.is_some_and(|tuning| self.has_margins(&tuning.control))
        };
        let (slowest, fastest) = BANDWIDTHS_RAD_S;
        holds(slowest).then(|| tuning(bisect(slowest, fastest, holds)))?
    }

    fn has_margins(&self, control: &ControlParameters) -> bool {
        self.least(control).is_some_and(|least| {
            least.phase_deg >= LEAST_PHASE_DEG && least.gain_db >= LEAST_GAIN_DB
        })
    }
}
