//! Instants, us.

/// So long after an instant; at the end of all instants at the latest. On the board all timers share this one.
#[cfg_attr(target_os = "none", inline(never))]
pub(crate) const fn later(now_us: u64, by_us: u64) -> u64 {
    now_us.saturating_add(by_us)
}
