//! The search for a position loop with a target bandwidth and phase margin.
//!
//! The unknowns are the inner bandwidth `w` and the share `P/w`. For each share, bisection finds
//! the smallest inner bandwidth that gives at least the target bandwidth. A large share requires a
//! small `w` and therefore small gains, but has low damping; a small share requires a fast inner
//! loop, whose delays reduce the phase margin. The largest share with sufficient phase margin is
//! selected.

use super::{PositionLoop, TuneError, TuneRequest};
use crate::analysis::frequency::{HALF_POWER_DB, bisect, decibel, logarithmic_grid};
use crate::analysis::linear_models::Loop;
use crate::analysis::loop_gain::Margins;
use crate::analysis::transfer_function::TransferFunction;
use model_core::parameter::ParameterError;

// Range of the shares P/w: from 0.02, where P determines the bandwidth, to 2, where the phase
// margin without any delay is 38.7 degrees.
const MIN_SHARE: f64 = 0.02;
const MAX_SHARE: f64 = 2.0;
const SHARES_PER_DECADE: usize = 20;

// Range of the inner bandwidths, as multiples of the target bandwidth. Without delay the multiple
// is from 0.5 (share 2) to 50 (share 0.02).
const MIN_MULTIPLE: f64 = 0.05;
const MAX_MULTIPLE: f64 = 200.0;
const MULTIPLES_PER_DECADE: usize = 12;

// Density of the frequencies below the target bandwidth at which the gain is checked. Resonances
// and notches of the loop are wider than a fifteenth of a decade.
const LEVELS_PER_DECADE: usize = 15;

/// The inner bandwidth, rad/s, and the share that meet the goal. If no share has the phase margin,
/// those with the largest phase margin.
///
/// # Errors
/// A parameter of the request that is out of range, or a bandwidth that cannot be reached.
pub(super) fn position_loop(
    request: &TuneRequest,
    goal: &PositionLoop,
) -> Result<(f64, f64), TuneError> {
    check(request)?;
    let target_hz = goal.bandwidth_hz;
    let candidates: Vec<Candidate> = shares()
        .filter_map(|share| Candidate::at(request, target_hz, share))
        .collect();
    let enough = |c: &Candidate| c.phase_margin_deg >= goal.phase_margin_deg;
    let found = candidates.iter().position(enough);
    let Some(index) = found else {
        let best = candidates
            .iter()
            .max_by(|a, b| a.phase_margin_deg.total_cmp(&b.phase_margin_deg));
        let best = best.ok_or_else(|| TuneError::BandwidthOutOfReach {
            target_hz,
            maximum_hz: maximum_hz(request, target_hz),
        })?;
        return Ok((best.inner_bandwidth_rad_s, best.share));
    };
    let found = &candidates[index];
    let refined = index.checked_sub(1).and_then(|previous| {
        let share = bisect(found.share, candidates[previous].share, |share| {
            Candidate::at(request, target_hz, share).is_some_and(|c| enough(&c))
        });
        Candidate::at(request, target_hz, share)
    });
    let chosen = refined.as_ref().unwrap_or(found);
    Ok((chosen.inner_bandwidth_rad_s, chosen.share))
}

/// Checks the request. During the search the gains may be out of range.
fn check(request: &TuneRequest) -> Result<(), ParameterError> {
    let control = request.control;
    control.check()?;
    Loop::sampled(&request.motor, &control, &request.timing).map(|_| ())
}

/// The shares, largest first.
fn shares() -> impl Iterator<Item = f64> {
    logarithmic_grid(MIN_SHARE, MAX_SHARE, SHARES_PER_DECADE)
        .into_iter()
        .rev()
}

/// A loop with the target bandwidth.
struct Candidate {
    inner_bandwidth_rad_s: f64,
    share: f64,
    phase_margin_deg: f64,
}

impl Candidate {
    /// The stable loop with this share and bandwidth, if there is one.
    fn at(request: &TuneRequest, target_hz: f64, share: f64) -> Option<Self> {
        let inner_bandwidth_rad_s = inner_bandwidth_rad_s(request, target_hz, share)?;
        let margins = Margins::of(&servo(request, inner_bandwidth_rad_s, share)?);
        Some(Self {
            inner_bandwidth_rad_s,
            share,
            phase_margin_deg: margins.phase_deg?.value,
        })
    }
}

/// The loop with this inner bandwidth and share, if its gains are in range and it is stable.
fn servo(request: &TuneRequest, inner_bandwidth_rad_s: f64, share: f64) -> Option<Loop> {
    let control = request.gains(inner_bandwidth_rad_s, share);
    let servo = Loop::sampled(&request.motor, &control, &request.timing).ok()?;
    servo.closed.is_stable().then_some(servo)
}

/// The smallest inner bandwidth that gives the target bandwidth with this share.
fn inner_bandwidth_rad_s(request: &TuneRequest, target_hz: f64, share: f64) -> Option<f64> {
    let passes =
        |inner: f64| servo(request, inner, share).map(|servo| reaches(&servo.closed, target_hz));
    let target_rad_s = std::f64::consts::TAU * target_hz;
    let grid = logarithmic_grid(
        MIN_MULTIPLE * target_rad_s,
        MAX_MULTIPLE * target_rad_s,
        MULTIPLES_PER_DECADE,
    );
    let short = grid
        .iter()
        .take_while(|inner| passes(**inner) == Some(false))
        .count();
    let (below, above) = (*grid.get(short.checked_sub(1)?)?, *grid.get(short)?);
    // Even if the loop at `above` is unstable, one between may reach the bandwidth.
    let inner = bisect(below, above, |inner| passes(inner) == Some(false));
    // Increased by a rounding error, so that the loop has at least the target bandwidth.
    let inner = inner * (1.0 + 1e-12);
    (passes(inner) == Some(true)).then_some(inner)
}

/// Whether the gain is above half power at all frequencies up to this one. Checking this frequency
/// only is not sufficient: the gain may fall below and rise again in a resonance.
fn reaches(closed: &TransferFunction, target_hz: f64) -> bool {
    // The loop has an integrator: its steady-state gain is one.
    let passes = |hz: f64| decibel(closed.at(hz).norm()) >= HALF_POWER_DB;
    target_hz < closed.nyquist_hz()
        && logarithmic_grid(0.03 * target_hz, target_hz, LEVELS_PER_DECADE)
            .into_iter()
            .rev()
            .all(passes)
}

/// The largest bandwidth that any share reaches, searched below `beyond_hz`.
fn maximum_hz(request: &TuneRequest, beyond_hz: f64) -> f64 {
    bisect(0.0, beyond_hz, |hz| {
        shares().any(|share| inner_bandwidth_rad_s(request, hz, share).is_some())
    })
}
