//! Register accesses of the firmware, and events of the controller.

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::Layout;
use rigless::soc::stm32f427::generated::can1::Register as R;
use rigless::time::{EventId, VirtualNanos};

use super::mode::Mode;
use super::status::LastError;
use super::{BxCan, mcr};

impl BxCan {
    fn write_control(&mut self, value: u32) {
        if value & mcr::RESET != 0 {
            // A reset preserves the filters (RM0090, section 32.9.2), and the state of the
            // interrupt lines until they are driven again.
            let (filters, lines) = (self.filters.clone(), self.lines);
            self.restart();
            (self.filters, self.lines) = (filters, lines);
        } else {
            self.control = value;
        }
    }

    fn write_mailbox(&mut self, row: usize, value: u32) {
        let (index, word) = (row / 4, row % 4);
        let mailbox = &mut self.mailboxes.boxes[index];
        // A mailbox that is not empty is write-protected.
        if mailbox.is_pending {
            return;
        }
        mailbox.words[word] = value;
        if word == 0 && value & 1 != 0 {
            self.mailboxes.request(index);
        }
    }

    fn write_transmit_status(&mut self, value: u64) {
        for index in 0..self.mailboxes.boxes.len() {
            let byte = value >> (8 * index);
            if byte & 1 != 0 {
                self.mailboxes.boxes[index].flags = Default::default();
            }
            if byte & 1 << 7 != 0 {
                self.abort(index);
            }
        }
    }

    fn write_filters(&mut self, register: R, value: u32) {
        self.shows_filters = false;
        let initialising = self.filters.is_initialising();
        let filters = &mut self.filters;
        match register {
            R::Fmr => filters.control = 0x2a1c_0000 | value & 0x3f01,
            R::Fa1r => filters.is_active = value,
            R::Fm1r if initialising => filters.is_list = value,
            R::Fs1r if initialising => filters.is_wide = value,
            R::Ffa1r if initialising => filters.to_second = value,
            _ => {
                let Some(row) = register.index().checked_sub(R::F0r1.index()) else {
                    return;
                };
                let is_active = filters.is_active >> (row / 2) & 1 != 0;
                let word = filters.banks.as_flattened_mut().get_mut(row);
                if let Some(word) = word.filter(|_| initialising || !is_active) {
                    *word = value;
                }
            }
        }
    }

    fn write_master_status(&mut self, value: u64) {
        self.status.has_error_interrupt &= value & 1 << 2 == 0;
        self.status.woke &= value & 1 << 3 == 0;
        self.status.acknowledges_sleep &= value & 1 << 4 == 0;
    }

    /// Advances the controller and its own bus, if it has one, to the present; then schedules the
    /// next event.
    pub(crate) fn proceed(
        &mut self,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let now_ns = context.now().0;
        if self.current.is_some_and(|current| current.is_internal) {
            self.finish_current(now_ns);
        }
        let wire_ended = self.wire.as_mut().and_then(|wire| wire.finish(now_ns, 1));
        if wire_ended.is_some() || self.wire.is_none() {
            self.finish_current(now_ns);
        }
        self.advance_mode(now_ns);
        self.follow_requests(now_ns);
        self.start(now_ns);
        self.update_offer(now_ns);
        self.publish(registers, context);
        self.schedule(context);
    }

    fn start(&mut self, now_ns: u64) {
        if self.is_internal() {
            self.begin_internal(now_ns);
        }
        if self
            .wire_due_ns(now_ns)
            .is_none_or(|due_ns| due_ns > now_ns)
        {
            return;
        }
        let station = self.station(now_ns).filter(|_| !self.is_internal());
        let Some(wire) = &mut self.wire else {
            return;
        };
        if let Some((ends_ns, transfer)) = wire.start(now_ns, &[station]) {
            self.begin(now_ns, ends_ns, transfer, 0);
        }
    }

    /// When its own bus ends a frame or arbitrates next, ns.
    fn wire_due_ns(&self, now_ns: u64) -> Option<u64> {
        let wire = self.wire.as_ref()?;
        wire.next_ns(now_ns, !self.is_internal() && self.offers(now_ns))
    }

    /// Schedules the controller's next event. Each scheduled event stops the core, one that has been
    /// replaced too.
    pub fn schedule(&mut self, context: &mut DeviceContext<'_>) {
        let now_ns = context.now().0;
        let carried_ns = self.current.map(|current| current.ends_ns);
        let next_ns = [self.wire_due_ns(now_ns), carried_ns, self.mode_due_ns()];
        let next_ns = next_ns.into_iter().flatten().min();
        let next_ns = next_ns.map(|at_ns| at_ns.max(now_ns + 1));
        if next_ns != self.wake.map(|(at_ns, _)| at_ns) {
            self.wake = next_ns.map(|at_ns| (at_ns, context.schedule(VirtualNanos(at_ns))));
        }
    }
}

impl Device for BxCan {
    type Register = R;

    fn write(
        &mut self,
        register: R,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let word = value as u32;
        match register {
            R::Mcr => self.write_control(word),
            R::Msr => self.write_master_status(value),
            R::Tsr => self.write_transmit_status(value),
            R::Rf0r => self.fifos[0].write(value),
            R::Rf1r => self.fifos[1].write(value),
            R::Ier => self.status.enabled = word,
            R::Esr if value >> 4 & 7 == 7 => self.status.last_error = LastError::SetBySoftware,
            R::Btr if self.mode == Mode::Initialising => self.bit_timing = word,
            R::Esr | R::Btr => {}
            other => match other.index().checked_sub(R::Ti0r.index()) {
                Some(row) if row < 12 => self.write_mailbox(row, word),
                _ => self.write_filters(other, word),
            },
        }
        self.proceed(registers, context);
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if self.wake.take_if(|(_, wake)| *wake == event).is_some() {
            self.proceed(registers, context);
        }
    }

    /// Checks for frames queued at ports.
    fn poll(&mut self, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.wire.as_ref().is_some_and(|wire| !wire.is_busy()) {
            self.schedule(context);
        }
    }

    fn on_clock(&mut self, hz: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {
        self.clock_hz = hz;
    }

    fn reset(&mut self) {
        self.restart();
    }

    fn reset_line(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.restart();
        self.publish(registers, context);
        self.schedule(context);
    }
}
