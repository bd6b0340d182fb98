//! Status registers and the four interrupt lines (RM0090, section 32.8).

use rigless::device::{DeviceContext, Level, RegisterFile};
use rigless::soc::Layout;
use rigless::soc::stm32f427::generated::can1::Register as R;

use super::super::ErrorState;
use super::super::filters::BANKS;
use super::mode::Mode;
use super::{BxCan, FrameInProgress, mcr};

/// `ESR.LEC`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum LastError {
    #[default]
    None = 0,
    Stuff = 1,
    Form = 2,
    Acknowledge = 3,
    BitRecessive = 4,
    BitDominant = 5,
    SetBySoftware = 7,
}

/// Latched flags.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Status {
    /// `IER`.
    pub enabled: u32,
    pub last_error: LastError,
    /// `MSR.ERRI`.
    pub has_error_interrupt: bool,
    /// `MSR.WKUI`.
    pub woke: bool,
    /// `MSR.SLAKI`.
    pub acknowledges_sleep: bool,
    /// `EWGF`, `EPVF`, `BOFF` as last published.
    flags: u32,
    /// Whether an error occurred since the last publication.
    has_noted: bool,
}

/// Bits of `IER`.
mod ier {
    pub const TMEIE: u32 = 1;
    pub const ERRIE: u32 = 1 << 15;
    pub const WKUIE: u32 = 1 << 16;
    pub const SLKIE: u32 = 1 << 17;
    /// `EWGIE`, `EPVIE`, `BOFIE`: in `ESR` eight lower.
    pub const FLAGS_SHIFT: u32 = 8;
    pub const LECIE: u32 = 1 << 11;
}

impl Status {
    pub fn record(&mut self, error: LastError) {
        self.last_error = error;
        self.has_noted |= error != LastError::None;
    }

    /// Sets `ERRI` at a rising flag, or an error, whose interrupt is enabled.
    fn latch(&mut self, flags: u32) {
        let risen = flags & !self.flags;
        let by_flag = risen & (self.enabled >> ier::FLAGS_SHIFT) & 0b111 != 0;
        let by_error = self.has_noted && self.enabled & ier::LECIE != 0;
        self.has_error_interrupt |= by_flag || by_error;
        self.flags = flags;
        self.has_noted = false;
    }
}

const TX: usize = 0;
const RX: [usize; 2] = [1, 2];
const SCE: usize = 3;

const MAILBOX_ROWS: [R; 3] = [R::Ti0r, R::Ti1r, R::Ti2r];
const OUTPUT_ROWS: [R; 2] = [R::Ri0r, R::Ri1r];

/// Sets the register at a distance from another.
fn setter(registers: &mut RegisterFile) -> impl FnMut(R, usize, u64) {
    |first, rows, value| {
        if let Some(register) = R::from_index(first.index() + rows) {
            registers.set(register, value);
        }
    }
}

impl BxCan {
    fn error_flags(&self) -> u32 {
        let state = self.counters.state();
        u32::from(self.counters.is_warning())
            | u32::from(state != ErrorState::Active) << 1
            | u32::from(state == ErrorState::BusOff) << 2
    }

    fn master_status(&self) -> u64 {
        let sends = |current: FrameInProgress| current.mailbox.is_some();
        let initialises = matches!(self.mode, Mode::Initialising | Mode::Joining { .. });
        u64::from(initialises)
            | u64::from(self.mode == Mode::Asleep) << 1
            | u64::from(self.status.has_error_interrupt) << 2
            | u64::from(self.status.woke) << 3
            | u64::from(self.status.acknowledges_sleep) << 4
            | u64::from(self.current.is_some_and(sends)) << 8
            | u64::from(self.current.is_some_and(|current| !sends(current))) << 9
            // The line is recessive between frames.
            | 1 << 10
            | u64::from(self.current.is_none()) << 11
    }

    /// Updates the registers and the interrupt lines.
    pub(super) fn publish(
        &mut self,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let flags = self.error_flags();
        self.status.latch(flags);
        let counters =
            u64::from(self.counters.transmit()) << 16 | u64::from(self.counters.receive()) << 24;
        registers.set(R::Mcr, self.control.into());
        registers.set(R::Msr, self.master_status());
        registers.set(R::Tsr, self.mailboxes.register(self.is(mcr::TXFP)));
        registers.set(R::Rf0r, self.fifos[0].register());
        registers.set(R::Rf1r, self.fifos[1].register());
        registers.set(R::Ier, self.status.enabled.into());
        let error = u64::from(flags) | (self.status.last_error as u64) << 4 | counters;
        registers.set(R::Esr, error);
        registers.set(R::Btr, self.bit_timing.into());
        self.publish_frames(registers);
        if !self.shows_filters {
            self.publish_filters(registers);
            self.shows_filters = true;
        }
        self.drive_lines(context);
    }

    fn publish_frames(&self, registers: &mut RegisterFile) {
        let mut put = setter(registers);
        for (first, mailbox) in MAILBOX_ROWS.into_iter().zip(&self.mailboxes.boxes) {
            for (row, word) in mailbox.words.iter().enumerate() {
                let request = row == 0 && mailbox.is_pending;
                put(
                    first,
                    row,
                    u64::from(word & !u32::from(row == 0)) | u64::from(request),
                );
            }
        }
        for (fifo, first) in OUTPUT_ROWS.into_iter().enumerate() {
            for (row, word) in self.output_registers(fifo).into_iter().enumerate() {
                put(first, row, word);
            }
        }
    }

    fn publish_filters(&self, registers: &mut RegisterFile) {
        let mut put = setter(registers);
        let filters = &self.filters;
        let control = [
            filters.control,
            filters.is_list,
            filters.is_wide,
            filters.to_second,
            filters.is_active,
        ];
        for (row, word) in control.into_iter().enumerate() {
            put(R::Fmr, row, word.into());
        }
        for (row, word) in filters.banks.as_flattened().iter().enumerate() {
            put(R::F0r1, row, (*word).into());
        }
        debug_assert_eq!(filters.banks.len(), BANKS);
    }

    fn drive_lines(&mut self, context: &mut DeviceContext<'_>) {
        let enabled = |bits: u32| self.status.enabled & bits != 0;
        let mut asserted = [false; 4];
        asserted[TX] = enabled(ier::TMEIE) && self.mailboxes.has_complete();
        for ((line, fifo), shift) in RX.into_iter().zip(&self.fifos).zip([1, 4]) {
            asserted[line] = enabled(1 << shift) && fifo.len() > 0
                || enabled(1 << (shift + 1)) && fifo.is_full
                || enabled(1 << (shift + 2)) && fifo.has_overrun;
        }
        asserted[SCE] = enabled(ier::ERRIE) && self.status.has_error_interrupt
            || enabled(ier::WKUIE) && self.status.woke
            || enabled(ier::SLKIE) && self.status.acknowledges_sleep;
        for (line, (asserted, driven)) in asserted.into_iter().zip(&mut self.lines).enumerate() {
            let level = Level::from(asserted);
            if level != *driven {
                *driven = level;
                context.interrupt(line, level);
            }
        }
    }
}
