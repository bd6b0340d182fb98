//! The window watchdog WWDG (RM0090, chapter 22).
//!
//! The counter counts the clock of APB1 divided by 4096 and the prescaler. It resets the part when
//! it falls below 40h, when it is written with a value below 40h, and when it is written while it
//! is above the window. Not modelled: the early wake-up interrupt; a count that is read back; a
//! change of the clock while the counter runs.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::stm32f427::generated::wwdg::Register as R;
use rigless::time::{EventId, VirtualNanos};

/// Bits of CR and CFR (sections 22.6.1 and 22.6.2).
const ACTIVE: u64 = 1 << 7;
const COUNTER: u64 = 0x7f;
const WINDOW: u64 = 0x7f;
const PRESCALER_SHIFT: u64 = 7;

/// Cycles of the first divider.
const DIVIDER: u64 = 4096;

/// The least count that does not reset.
const LEAST: u64 = 0x40;

/// The watchdog.
#[derive(Debug, Default)]
pub struct WindowWatchdog {
    clock_hz: u64,
    is_active: bool,
    /// Instant of the last write of the counter, ns, and the count written.
    written: (u64, u64),
    /// Instant of the reset if the counter is not written until then, ns.
    expiry_ns: u64,
    /// The next event, and its instant, ns.
    event: Option<(u64, EventId)>,
}

impl WindowWatchdog {
    /// Duration of a count, ns; `None` without a clock.
    fn count_ns(&self, registers: &RegisterFile) -> Option<u64> {
        let divider = DIVIDER << (registers.get(R::Cfr) >> PRESCALER_SHIFT & 0b11);
        (divider * 1_000_000_000).checked_div(self.clock_hz)
    }

    fn write_counter(
        &mut self,
        value: u64,
        registers: &RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let Some(count_ns) = self.count_ns(registers) else {
            return;
        };
        let now_ns = context.now().0;
        let (written_ns, written) = self.written;
        let present = written.saturating_sub((now_ns - written_ns) / count_ns);
        let is_early = self.is_active && present > registers.get(R::Cfr) & WINDOW;
        // Once set, the bit remains.
        self.is_active |= value & ACTIVE != 0;
        if !self.is_active {
            return;
        }
        let count = value & COUNTER;
        if is_early || count < LEAST {
            context.request_reset();
            return;
        }
        self.written = (now_ns, count);
        self.expiry_ns = now_ns + (count - LEAST + 1) * count_ns;
        self.await_expiry(context);
    }

    /// Schedules an event at the expiry, unless an earlier one, which does so then, is pending: a
    /// replaced event would still stop the core.
    fn await_expiry(&mut self, context: &mut DeviceContext<'_>) {
        let at_ns = self.expiry_ns;
        if self.event.is_none_or(|(pending_ns, _)| pending_ns > at_ns) {
            self.event = Some((at_ns, context.schedule(VirtualNanos(at_ns))));
        }
    }
}

impl Device for WindowWatchdog {
    type Register = R;

    fn write(
        &mut self,
        register: R,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if register == R::Cr {
            self.write_counter(value, registers, context);
        }
    }

    fn on_event(&mut self, event: EventId, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.event.take_if(|(_, own)| *own == event).is_none() {
            return;
        }
        if context.now().0 >= self.expiry_ns {
            context.request_reset();
        } else {
            self.await_expiry(context);
        }
    }

    fn on_clock(&mut self, hz: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        self.clock_hz = hz;
    }

    fn reset(&mut self) {
        *self = Self {
            clock_hz: self.clock_hz,
            ..Self::default()
        };
    }
}

#[cfg(test)]
mod tests {
    use rigless::mcu::{Mcu, Operate, Single};
    use rigless::soc::{Layout, Width, stm32f427};

    use super::*;

    /// APB1 of the boards.
    const CLOCK_HZ: u64 = 42_000_000;
    /// A count with a prescaler of 8, ns.
    const COUNT_NS: u64 = 4096 * 8 * 1_000_000_000 / CLOCK_HZ;

    /// A watchdog with a prescaler of 8 and this window.
    fn watchdog(window: u64) -> Single<WindowWatchdog> {
        let watchdog = WindowWatchdog::default();
        let mut part = Single::new(stm32f427::builder(), "WWDG", watchdog).unwrap();
        part.drive(VirtualNanos(0), |watchdog, registers, context| {
            watchdog.on_clock(CLOCK_HZ, registers, context);
        });
        write(&mut part, 0, R::Cfr, 0b11 << PRESCALER_SHIFT | window);
        part
    }

    fn write(part: &mut Single<WindowWatchdog>, at_ns: u64, register: R, value: u64) {
        let base = part.bus().peripheral("WWDG").unwrap().base;
        let address = base + u64::from(register.spec().offset);
        let at = VirtualNanos(at_ns);
        part.advance_to(at);
        part.write(at, address, Width::W32, value).unwrap();
    }

    fn feed(part: &mut Single<WindowWatchdog>, at_ns: u64) {
        write(part, at_ns, R::Cr, ACTIVE | 0x5f);
    }

    fn has_reset(part: &mut Single<WindowWatchdog>) -> bool {
        part.take_reset_request().is_some()
    }

    #[test]
    fn it_resets_after_as_many_counts_as_it_was_fed_and_not_before() {
        let mut part = watchdog(0x7f);
        feed(&mut part, 0);
        part.advance_to(VirtualNanos(32 * COUNT_NS - 1));
        assert!(!has_reset(&mut part));
        part.advance_to(VirtualNanos(32 * COUNT_NS));
        assert!(has_reset(&mut part));
    }

    #[test]
    fn feeding_it_in_the_window_prevents_the_reset_and_above_the_window_resets() {
        let mut part = watchdog(0x5d);
        for turn in 0..100 {
            feed(&mut part, turn * 2 * COUNT_NS);
        }
        assert!(!has_reset(&mut part));
        feed(&mut part, 199 * COUNT_NS);
        assert!(has_reset(&mut part));
    }

    #[test]
    fn a_count_below_40h_resets_at_once() {
        let mut part = watchdog(0x7f);
        write(&mut part, 0, R::Cr, ACTIVE | 0x3f);
        assert!(has_reset(&mut part));
    }
}
