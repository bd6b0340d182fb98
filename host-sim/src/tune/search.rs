//! The search for a position loop of wanted bandwidth and phase margin.
//!
//! Two unknowns, the inner bandwidth `w` and the share `P/w`. For each share the inner bandwidth
//! that reaches the wanted bandwidth, or jumps beyond it, is found by bisection. A large share needs the least `w`, so
//! the least gains, and is damped least by its own structure; a small share needs a fast inner
//! loop, whose delays cost phase. The largest share with enough phase margin is taken.

use super::{PositionLoop, Request, TuneError};
use crate::analysis::frequency::{HALF_POWER_DB, bisect, decibel, logarithmic_grid};
use crate::analysis::linear_models::Loop;
use crate::analysis::loop_gain::Margins;
use crate::analysis::transfer_function::TransferFunction;
use model_core::parameter::ParameterError;

// Shares P/w searched: from 0.02, where P alone makes the bandwidth, to 2, where without any delay
// 38.7 degrees of phase margin are left.
const LEAST_SHARE: f64 = 0.02;
const GREATEST_SHARE: f64 = 2.0;
const SHARES_PER_DECADE: usize = 20;

// Inner bandwidths searched, as multiples of the wanted bandwidth. Without delay it takes from 0.5
// (share 2) to 50 (share 0.02).
const LEAST_MULTIPLE: f64 = 0.05;
const GREATEST_MULTIPLE: f64 = 200.0;
const MULTIPLES_PER_DECADE: usize = 12;

// Frequencies below the wanted bandwidth at which the gain is looked at. The loop's resonances and
// dips are wider than a decade's fifteenth.
const LEVELS_PER_DECADE: usize = 15;

/// The inner bandwidth, rad/s, and the share that reach the goal; where no share has the phase
/// margin, those with the most.
///
/// # Errors
/// A parameter of the request outside its range, or a bandwidth out of reach.
pub(super) fn position_loop(
    request: &Request,
    goal: &PositionLoop,
) -> Result<(f64, f64), TuneError> {
    check(request)?;
    let wanted_hz = goal.bandwidth_hz;
    let candidates: Vec<Candidate> = shares()
        .filter_map(|share| Candidate::at(request, wanted_hz, share))
        .collect();
    let enough = |c: &Candidate| c.phase_margin_deg >= goal.phase_margin_deg;
    let found = candidates.iter().position(enough);
    let Some(index) = found else {
        let best = candidates
            .iter()
            .max_by(|a, b| a.phase_margin_deg.total_cmp(&b.phase_margin_deg));
        let best = best.ok_or_else(|| TuneError::BandwidthOutOfReach {
            wanted_hz,
            greatest_hz: greatest_hz(request, wanted_hz),
        })?;
        return Ok((best.inner_bandwidth_rad_s, best.share));
    };
    let found = &candidates[index];
    let refined = index.checked_sub(1).and_then(|previous| {
        let share = bisect(found.share, candidates[previous].share, |share| {
            Candidate::at(request, wanted_hz, share).is_some_and(|c| enough(&c))
        });
        Candidate::at(request, wanted_hz, share)
    });
    let chosen = refined.as_ref().unwrap_or(found);
    Ok((chosen.inner_bandwidth_rad_s, chosen.share))
}

/// Checks what the search relies on; gains that it meets on its way may lie outside their range.
fn check(request: &Request) -> Result<(), ParameterError> {
    let control = request.control;
    control.check()?;
    Loop::sampled(&request.motor, &control, &request.timing).map(|_| ())
}

/// The shares, largest first.
fn shares() -> impl Iterator<Item = f64> {
    logarithmic_grid(LEAST_SHARE, GREATEST_SHARE, SHARES_PER_DECADE)
        .into_iter()
        .rev()
}

/// A loop of the wanted bandwidth.
struct Candidate {
    inner_bandwidth_rad_s: f64,
    share: f64,
    phase_margin_deg: f64,
}

impl Candidate {
    /// The loop with this share that has this bandwidth, if a stable one has.
    fn at(request: &Request, wanted_hz: f64, share: f64) -> Option<Self> {
        let inner_bandwidth_rad_s = inner_bandwidth_rad_s(request, wanted_hz, share)?;
        let margins = Margins::of(&servo(request, inner_bandwidth_rad_s, share)?);
        Some(Self {
            inner_bandwidth_rad_s,
            share,
            phase_margin_deg: margins.phase_deg?.value,
        })
    }
}

/// The loop at this inner bandwidth and share, if its gains are in range and it is stable.
fn servo(request: &Request, inner_bandwidth_rad_s: f64, share: f64) -> Option<Loop> {
    let control = request.gains(inner_bandwidth_rad_s, share);
    let servo = Loop::sampled(&request.motor, &control, &request.timing).ok()?;
    servo.closed.is_stable().then_some(servo)
}

/// The least inner bandwidth that gives this share the wanted bandwidth.
fn inner_bandwidth_rad_s(request: &Request, wanted_hz: f64, share: f64) -> Option<f64> {
    let passes = |inner: f64| {
        servo(request, inner, share).map(|servo| lets_through(&servo.closed, wanted_hz))
    };
    let wanted_rad_s = std::f64::consts::TAU * wanted_hz;
    let grid = logarithmic_grid(
        LEAST_MULTIPLE * wanted_rad_s,
        GREATEST_MULTIPLE * wanted_rad_s,
        MULTIPLES_PER_DECADE,
    );
    let short = grid
        .iter()
        .take_while(|inner| passes(**inner) == Some(false))
        .count();
    let (below, above) = (*grid.get(short.checked_sub(1)?)?, *grid.get(short)?);
    // A loop that becomes unstable before it passes may still pass on the way there.
    let inner = bisect(below, above, |inner| passes(inner) == Some(false));
    // The last digit upward, to the side that passes.
    let inner = inner * (1.0 + 1e-12);
    (passes(inner) == Some(true)).then_some(inner)
}

/// Whether a loop lets all frequencies through up to this one. The last alone would not do: a loop
/// may fall at low frequencies and come back in a resonance.
fn lets_through(closed: &TransferFunction, wanted_hz: f64) -> bool {
    // The loop integrates: its gain at rest is one.
    let passes = |hz: f64| decibel(closed.at(hz).norm()) >= HALF_POWER_DB;
    wanted_hz < closed.nyquist_hz()
        && logarithmic_grid(0.03 * wanted_hz, wanted_hz, LEVELS_PER_DECADE)
            .into_iter()
            .rev()
            .all(passes)
}

/// The most bandwidth that any share reaches, searched below `beyond_hz`.
fn greatest_hz(request: &Request, beyond_hz: f64) -> f64 {
    bisect(0.0, beyond_hz, |hz| {
        shares().any(|share| inner_bandwidth_rad_s(request, hz, share).is_some())
    })
}
