//! Register accesses of the firmware, and events of the controller.

use rigless::device::{DeviceContext, ErasedDevice, Level, RegisterFile, RequestChange};
use rigless::soc::{RegisterSpec, Width};
use rigless::time::{EventId, VirtualNanos};

use super::super::ErrorState;
use super::filters::list;
use super::registers::{LBCK, LastError, RELEASE, cccr, ir, offset};
use super::{FdCan, Fifo, Mode};

impl FdCan {
    /// Advances the controller and its own bus, if it has one, to the present; then schedules the
    /// next event.
    pub(crate) fn proceed(&mut self, context: &mut DeviceContext<'_>) {
        let now_ns = context.now().0;
        if self.current.is_some_and(|current| current.is_internal) {
            self.finish_current(now_ns);
        }
        let wire_ended = self.wire.as_mut().and_then(|wire| wire.finish(now_ns, 1));
        if wire_ended.is_some() || self.wire.is_none() {
            self.finish_current(now_ns);
        }
        self.advance_mode(now_ns);
        self.start(now_ns);
        self.update_offer(now_ns);
        self.latch_states();
        self.drive_lines(context);
        self.schedule(context);
    }

    fn start(&mut self, now_ns: u64) {
        if self.is_internal() {
            self.begin_internal(now_ns);
        }
        let station = self.station().filter(|_| !self.is_internal());
        let Some(wire) = &mut self.wire else {
            return;
        };
        if let Some((ends_ns, transfer)) = wire.start(now_ns, &[station]) {
            self.begin(ends_ns, transfer, 0);
        }
    }

    fn schedule(&mut self, context: &mut DeviceContext<'_>) {
        let now_ns = context.now().0;
        let offers = self
            .station()
            .is_some_and(|station| station.offer.is_some());
        let offers_wire = offers && !self.is_internal();
        let wire_ns = self
            .wire
            .as_ref()
            .and_then(|wire| wire.next_ns(now_ns, offers_wire));
        let carried_ns = self.current.map(|current| current.ends_ns);
        let joins_ns = match self.mode {
            Mode::Joining { ready_ns } => Some(ready_ns),
            Mode::Initialising | Mode::Running => None,
        };
        let next_ns = [wire_ns, carried_ns, joins_ns];
        let next_ns = next_ns.into_iter().flatten().min();
        self.wake = next_ns.map(|at_ns| context.schedule(VirtualNanos(at_ns.max(now_ns + 1))));
    }

    /// Flags of changes of the error state.
    fn latch_states(&mut self) {
        let state = self.counters.state();
        let is = [
            state != ErrorState::Active,
            self.counters.is_warning(),
            state == ErrorState::BusOff,
        ];
        for ((is, was), flag) in is.iter().zip(self.was).zip([ir::EP, ir::EW, ir::BO]) {
            if *is != was {
                self.flags |= flag;
            }
        }
        self.was = is;
    }

    fn drive_lines(&mut self, context: &mut DeviceContext<'_>) {
        let active = self.flags & self.settings.enabled;
        let select = self.settings.line_select;
        let asserted = [active & !select, active & select];
        for (line, (active, driven)) in asserted.into_iter().zip(&mut self.lines).enumerate() {
            let is_enabled = self.settings.line_enable >> line & 1 != 0;
            let level = Level::from(is_enabled && active != 0);
            if level != *driven {
                *driven = level;
                context.interrupt(line, level);
            }
        }
    }

    fn write_control(&mut self, value: u32, context: &mut DeviceContext<'_>) {
        if value & !cccr::MODELLED != 0 {
            context.tell("CCCR", "this bit is not modelled");
        }
        let was_open = self.is(cccr::CCE);
        let init = value & cccr::INIT;
        // The configuration can change while the controller is off the bus.
        let open = if init != 0 && self.is(cccr::INIT) {
            value & cccr::CCE
        } else {
            0
        };
        let changeable = if was_open { cccr::MODELLED } else { 0 };
        self.control = self.control & !changeable | value & changeable;
        self.control = self.control & !(cccr::INIT | cccr::CCE) | init | open;
        if !was_open && open != 0 {
            self.fifo = Fifo::default();
            (self.pending, self.cancelling) = (0, 0);
            (self.transmitted, self.cancelled) = (0, 0);
        }
    }

    /// Writes a register that is open for changes only off the bus; returns whether it is one.
    fn write_protected(&mut self, register: u64, value: u32) -> bool {
        let settings = &mut self.settings;
        let place = match register {
            offset::TEST => &mut settings.test,
            offset::NBTP => &mut settings.bit_timing,
            offset::GFC => &mut settings.global_filter,
            offset::SIDFC => &mut settings.standard_filters,
            offset::XIDFC => &mut settings.extended_filters,
            offset::RXF0C => &mut settings.fifo,
            offset::TXBC => &mut settings.buffers,
            _ => return false,
        };
        if self.control & cccr::CCE != 0 {
            *place = value;
        }
        true
    }

    fn write_register(&mut self, register: u64, value: u32, context: &mut DeviceContext<'_>) {
        if self.write_protected(register, value) {
            let is_modelled = match register {
                offset::TEST => value & !LBCK == 0,
                // Dedicated buffers alone; reject what no filter accepts.
                offset::TXBC => value >> 24 == 0,
                offset::GFC => value == 0b10_1000,
                _ => true,
            };
            if !is_modelled {
                context.tell("configuration", "this setting is not modelled");
            }
            return;
        }
        match register {
            offset::CCCR => self.write_control(value, context),
            offset::IR => self.flags &= !value,
            offset::IE => self.settings.enabled = value,
            offset::ILS => self.settings.line_select = value,
            offset::ILE => self.settings.line_enable = value,
            offset::RXF0A => self.acknowledge(value & 0x3f),
            offset::TXBAR if !self.is(cccr::CCE) => self.request(value),
            offset::TXBCR if !self.is(cccr::CCE) => self.cancel(value),
            offset::TXBTIE => self.settings.complete_enabled = value,
            offset::TXBCIE => self.settings.cancelled_enabled = value,
            offset::RXESC | offset::TXESC if value == 0 => {}
            _ => context.tell("register", "this write is not modelled"),
        }
    }

    /// The content of a register; `None` if it is not modelled.
    fn register(&self, register: u64) -> Option<u32> {
        let settings = &self.settings;
        Some(match register {
            offset::CREL => RELEASE,
            offset::TEST => settings.test,
            offset::CCCR => self.control,
            offset::NBTP => settings.bit_timing,
            offset::ECR => {
                let receive = u32::from(self.counters.receive());
                let is_passive = receive > 127;
                u32::from(self.counters.transmit())
                    | receive.min(127) << 8
                    | u32::from(is_passive) << 15
            }
            offset::PSR => {
                let [is_passive, is_warned, is_off] = self.was.map(u32::from);
                0x700 | self.last_error as u32 | is_passive << 5 | is_warned << 6 | is_off << 7
            }
            offset::IR => self.flags,
            offset::IE => settings.enabled,
            offset::ILS => settings.line_select,
            offset::ILE => settings.line_enable,
            offset::GFC => settings.global_filter,
            offset::SIDFC => settings.standard_filters,
            offset::XIDFC => settings.extended_filters,
            offset::RXF0C => settings.fifo,
            offset::RXF0S => {
                let (_, size) = list(settings.fifo, 0x7f);
                let put = (self.fifo.get + self.fifo.level) % size.max(1);
                let is_full = size != 0 && self.fifo.level == size;
                let has_lost = self.flags & ir::RF0L != 0;
                self.fifo.level
                    | self.fifo.get << 8
                    | put << 16
                    | u32::from(is_full) << 24
                    | u32::from(has_lost) << 25
            }
            offset::TXBC => settings.buffers,
            offset::TXBRP => self.pending,
            offset::TXBTO => self.transmitted,
            offset::TXBCF => self.cancelled,
            offset::TXBTIE => settings.complete_enabled,
            offset::TXBCIE => settings.cancelled_enabled,
            offset::RXESC | offset::TXESC | offset::RXF0A | offset::TXBAR | offset::TXBCR => 0,
            _ => return None,
        })
    }
}

impl ErasedDevice for FdCan {
    fn layout(&self) -> &'static [RegisterSpec] {
        self.layout
    }

    fn read_window(&mut self, offset: u64, _: Width, context: &mut DeviceContext<'_>) -> u64 {
        let value = self.register(offset);
        if value.is_none() {
            context.tell("register", "this read is not modelled");
        }
        if offset == offset::PSR {
            self.last_error = LastError::NoChange;
        }
        value.unwrap_or(0).into()
    }

    fn write_window(
        &mut self,
        offset: u64,
        width: Width,
        value: u64,
        context: &mut DeviceContext<'_>,
    ) {
        if width != Width::W32 {
            context.tell("register", "only words are written");
        }
        self.write_register(offset, value as u32, context);
        self.proceed(context);
    }

    fn peek_window(&self, offset: u64, _: Width, _: VirtualNanos) -> Option<u64> {
        self.register(offset).map(u64::from)
    }

    fn on_event(&mut self, event: EventId, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.wake == Some(event) {
            self.proceed(context);
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

    fn reset_line(&mut self, _: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.restart();
        self.drive_lines(context);
        self.schedule(context);
    }

    // It has no register table, requests or accesses of its own.

    fn read(&mut self, _: usize, _: &mut RegisterFile, _: &mut DeviceContext<'_>) -> Option<u64> {
        None
    }

    fn write(&mut self, _: usize, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_request(&mut self, _: RequestChange, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_access(&mut self, _: u64, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}

    fn on_refused(&mut self, _: u64, _: &mut RegisterFile, _: &mut DeviceContext<'_>) {}
}
