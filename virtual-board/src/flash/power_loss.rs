//! What is left of an operation that the supply did not outlast.

use rand_pcg::{Pcg32, rand_core::Rng};
use rigless::device::DeviceContext;

use super::operation::{IGNORED, Operation, Started, fill, width};

/// A generator of what no firmware can foresee.
pub(super) fn chance(seed: u64, at_ns: u64) -> Pcg32 {
    Pcg32::new(seed, at_ns)
}

fn word(chance: &mut Pcg32) -> u64 {
    u64::from(chance.next_u32()) | u64::from(chance.next_u32()) << 32
}

/// Leaves the unit with some of the bits cleared that were to be cleared, given what it held.
pub(super) fn leave_half_programmed(
    started: &Started,
    held: u64,
    seed: u64,
    at_ns: u64,
    context: &mut DeviceContext<'_>,
) {
    let Operation::Program { address, bytes, value } = started.operation else {
        return;
    };
    let reached = word(&mut chance(seed, at_ns));
    context.program(address, width(bytes), held & (value | reached), IGNORED);
}

/// Leaves a sector half erased: early on, cells still hold their zeros here and there, and towards
/// the end hardly any do. No word of it can be relied on.
pub(super) fn leave_half_erased(
    started: &Started,
    seed: u64,
    at_ns: u64,
    context: &mut DeviceContext<'_>,
) {
    let Operation::Erase { base, size } = started.operation else {
        return;
    };
    let mut chance = chance(seed, at_ns);
    let whole_ns = (started.until_ns - started.from_ns).max(1);
    let quarter = at_ns.saturating_sub(started.from_ns) * 4 / whole_ns;
    fill(base, size, context, |_| {
        // Each step halves the share of zeros.
        (0..=quarter).fold(0, |ones, _| ones | word(&mut chance))
    });
}
