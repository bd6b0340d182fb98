//! Several plants at once, each in a lane: what is common to all kinds.
//!
//! Each quantity is an array with one element a plant, and each operation a loop over them without
//! branches, of which the compiler makes vectors.

use super::PlantState;
use crate::{
    actuator::{PlantKind, Settings},
    limits::{greater, lesser},
    parameter::ParameterError,
};

/// Plants that are driven by the mean voltage.
pub trait PlantLanes<const N: usize>: Sized {
    /// What the plants are.
    const KIND: PlantKind;

    /// The plants of these settings, at rest at zero; `None` where they cannot be computed side by
    /// side.
    ///
    /// # Errors
    /// That of the first parameter which is out of its range.
    fn try_new(settings: [&Settings; N]) -> Result<Option<Self>, ParameterError>;

    /// The states at the start of the next period.
    fn states(&self) -> &States<N>;

    /// Advances one period; outputs the first `ticks` ticks, from 1 to 80: all of them, or those at
    /// the start of a PWM period. The duties, in steps of 2^-32 %, are in force from
    /// the second PWM period on.
    fn pass<const ALL: bool>(&mut self, duty: &[i64; N], ticks: usize, seen: &mut Extremes<N>);

    /// The state of a plant at the tick that was seen last.
    fn last_seen(&self, lane: usize) -> PlantState;

    /// Takes over the motion of a plant with the same parameters.
    fn keep(&mut self, other: &Self, lane: usize);
}

/// Steps of a duty in 1 %.
pub(super) const STEPS: f64 = 4_294_967_296.0;

/// A duty in steps as a floating-point number.
#[inline(always)]
pub(super) fn float(duty: i64) -> f64 {
    /// Doubles from here to twice as much are whole numbers, and their low bits count them.
    const WHOLE: f64 = (3_u64 << 51) as f64;
    // The duty is within +-100 * 2^32, below 2^39, so nothing is rounded. There are vector
    // instructions for this sum, and none for the cast before AVX-512.
    f64::from_bits(WHOLE.to_bits().wrapping_add_signed(duty)) - WHOLE
}

/// Angles and rates.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct States<const N: usize> {
    /// Angle of the output shaft, deg.
    pub angle_deg: [f64; N],
    /// Keeps the angle and the rate of a motor alone from being neighbours: of these the compiler
    /// makes a vector, and the next step waits for its shuffles (a control period in steps of 1 ms
    /// takes a sixth longer).
    apart: u64,
    /// Rate of the output shaft, deg/s.
    pub rate_deg_s: [f64; N],
}

impl<const N: usize> States<N> {
    pub(super) fn all(value: f64) -> Self {
        Self {
            angle_deg: [value; N],
            apart: 0,
            rate_deg_s: [value; N],
        }
    }

    /// The state of one plant.
    #[inline(always)]
    pub fn of(&self, lane: usize) -> PlantState {
        PlantState {
            angle_deg: self.angle_deg[lane],
            rate_deg_s: self.rate_deg_s[lane],
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, state: PlantState) {
        self.angle_deg[lane] = state.angle_deg;
        self.rate_deg_s[lane] = state.rate_deg_s;
    }
}

/// Least and greatest angle and rate.
#[derive(Debug, Clone, Copy)]
pub struct Extremes<const N: usize> {
    /// Least angle and rate.
    pub least: States<N>,
    /// Greatest angle and rate.
    pub greatest: States<N>,
}

impl<const N: usize> Default for Extremes<N> {
    fn default() -> Self {
        Self {
            least: States::all(f64::INFINITY),
            greatest: States::all(f64::NEG_INFINITY),
        }
    }
}

impl<const N: usize> Extremes<N> {
    /// Includes a state of one plant.
    #[inline(always)]
    pub(super) fn see(&mut self, lane: usize, state: PlantState) {
        self.least.set(lane, lesser_of(state, self.least.of(lane)));
        self.greatest
            .set(lane, greater_of(state, self.greatest.of(lane)));
    }
}

/// The lesser angle and the lesser rate.
#[inline(always)]
pub(super) fn lesser_of(a: PlantState, b: PlantState) -> PlantState {
    PlantState {
        angle_deg: lesser(a.angle_deg, b.angle_deg),
        rate_deg_s: lesser(a.rate_deg_s, b.rate_deg_s),
    }
}

/// The greater angle and the greater rate.
#[inline(always)]
pub(super) fn greater_of(a: PlantState, b: PlantState) -> PlantState {
    PlantState {
        angle_deg: greater(a.angle_deg, b.angle_deg),
        rate_deg_s: greater(a.rate_deg_s, b.rate_deg_s),
    }
}
