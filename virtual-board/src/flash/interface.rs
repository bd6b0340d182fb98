//! The flash interface: its state, and the operations that its registers start.

mod device;
pub(in crate::flash) mod register;

use std::num::NonZeroU32;

use rigless::device::{DeviceContext, Level, RegisterFile};
use rigless::soc::stm32f427::generated::flash::Register;
use rigless::soc::stm32f427::peripherals::flash::Flash;
use rigless::time::EventId;

use self::register::{Key, cr, sr};
use super::operation::{Operation, Started};
use super::power_loss::Damage;
use super::{BANK_2, FlashTimes, Sector};

/// A planned supply loss during an operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cut {
    /// Number of the operation since power-on.
    operation: u64,
    permille: u64,
}

/// The flash interface. Option bytes and the check of the wait states are those of rigless.
#[derive(Debug)]
pub struct Interface {
    /// Durations of erase and program operations.
    pub times: FlashTimes,
    /// Seed of the contents after an interrupted operation.
    pub seed: u64,
    options: Flash,
    supply_mv: Option<NonZeroU32>,
    control: u64,
    status: u64,
    key: Key,
    started: Option<Started>,
    /// Event at the end of the operation.
    ends: Option<EventId>,
    cut_event: Option<EventId>,
    cut: Option<Cut>,
    damage: Option<Damage>,
    finishing: Option<Operation>,
    line: Level,
    operations: u64,
    log: Vec<Operation>,
}

impl Interface {
    /// An interface out of reset.
    pub fn new(times: FlashTimes, seed: u64) -> Self {
        Self {
            times,
            seed,
            options: Flash::with_clock(16_000_000),
            supply_mv: None,
            control: cr::LOCK,
            status: 0,
            key: Key::default(),
            started: None,
            ends: None,
            cut_event: None,
            cut: None,
            damage: None,
            finishing: None,
            line: Level::Low,
            operations: 0,
            log: Vec::new(),
        }
    }

    /// Sets the supply voltage, which determines wait states and parallelism, mV.
    pub fn set_supply(&mut self, supply_mv: NonZeroU32) {
        self.supply_mv = Some(supply_mv);
        self.options.set_supply(supply_mv);
    }

    /// Sets the option bytes, as a programmer does before the first start.
    pub fn set_options(&mut self, optcr: u64, registers: &mut RegisterFile) {
        let optcr1 = registers.get(Register::Optcr1);
        self.options.keep_options(optcr, optcr1, registers);
    }

    /// The operation in progress.
    pub fn running(&self) -> Option<&Started> {
        self.started.as_ref()
    }

    /// Whether the core is stalled: an operation changes the bank from which it executes.
    pub fn stalls_core(&self) -> bool {
        (self.started.as_ref()).is_some_and(|started| started.operation.address() < BANK_2)
    }

    /// Operations started since the last call.
    pub fn take_log(&mut self) -> Vec<Operation> {
        std::mem::take(&mut self.log)
    }

    /// Cuts the supply during the operation of this number, counted from 0 and from now on, after
    /// this share of its duration, thousandths.
    pub fn cut_during(&mut self, operation: u64, permille: u64) {
        let operation = self.operations + operation;
        self.cut = Some(Cut {
            operation,
            permille,
        });
    }

    /// Loss of the supply: interrupts the operation in progress.
    pub fn lose_power(&mut self, context: &mut DeviceContext<'_>) {
        if let Some(started) = self.started.take() {
            let damage = Damage::new(&started, self.seed, context.now().0);
            let operation = damage.operation();
            for address in operation.pieces() {
                context.read_from(address, operation.piece_width(), device::DAMAGE | address);
            }
            self.damage = Some(damage);
        }
        context.request_power(false);
    }

    /// Resets the interface; an operation in progress is lost.
    pub fn restart(&mut self, registers: &mut RegisterFile) {
        let (option, option_1) = self.options.committed_options();
        let mut options = Flash::with_clock(16_000_000);
        options.keep_options(option, option_1, registers);
        if let Some(supply_mv) = self.supply_mv {
            options.set_supply(supply_mv);
        }
        let log = std::mem::take(&mut self.log);
        *self = Self {
            options,
            supply_mv: self.supply_mv,
            log,
            cut: self.cut,
            operations: self.operations,
            ..Self::new(self.times, self.seed)
        };
    }

    fn is_busy(&self) -> bool {
        self.started.is_some()
    }

    fn is_set(&self, control: u64) -> bool {
        self.control & control != 0
    }

    fn start(&mut self, operation: Operation, duration_ns: u64, context: &mut DeviceContext<'_>) {
        let from_ns = context.now().0;
        let until_ns = from_ns + duration_ns;
        let at = |ns| rigless::time::VirtualNanos(ns);
        self.started = Some(Started {
            operation,
            from_ns,
            until_ns,
        });
        self.log.push(operation);
        let number = self.operations;
        self.operations += 1;
        if let Some(cut) = self.cut.take_if(|cut| cut.operation == number) {
            let after_ns = duration_ns * cut.permille.min(999) / 1000;
            self.cut_event = Some(context.schedule(at(from_ns + after_ns)));
        }
        self.ends = Some(context.schedule(at(until_ns)));
    }

    /// `STRT`.
    fn start_erase(&mut self, context: &mut DeviceContext<'_>) {
        let parallelism = (self.control >> cr::PSIZE_SHIFT & 0b11) as usize;
        let (base, size, duration_ns) = if self.is_set(cr::MER | cr::MER1) {
            let (first, second) = (self.is_set(cr::MER), self.is_set(cr::MER1));
            let base = if first { super::BASE } else { BANK_2 };
            let banks = u64::from(first) + u64::from(second);
            (
                base,
                banks * super::SIZE / 2,
                self.times.bank_ns(parallelism),
            )
        } else if self.is_set(cr::SER) {
            let Some(sector) = Sector::of_field(self.control >> cr::SNB_SHIFT & 0x1f) else {
                self.fail(sr::WRPERR);
                return;
            };
            let duration_ns = self.times.sector_ns(sector.size, parallelism);
            (sector.base, sector.size, duration_ns)
        } else {
            self.control &= !cr::STRT;
            return;
        };
        self.start(Operation::Erase { base, size }, duration_ns, context);
    }

    fn fail(&mut self, error: u64) {
        self.status |= error;
        if self.is_set(cr::ERRIE) {
            self.status |= sr::OPERR;
        }
        self.control &= !cr::STRT;
    }

    fn end(&mut self, context: &mut DeviceContext<'_>) {
        let Some(started) = self.started.take() else {
            return;
        };
        self.control &= !cr::STRT;
        if self.is_set(cr::EOPIE) {
            self.status |= sr::EOP;
        }
        let operation = started.operation;
        for address in operation.pieces() {
            match operation {
                Operation::Erase { .. } => {
                    context.program(address, operation.piece_width(), u64::MAX, device::IGNORED);
                }
                // Programming only clears bits: the present content is read first.
                Operation::Program { width, .. } => {
                    context.read_from(address, width, device::PROGRAM | address);
                }
            }
        }
        self.finishing = Some(operation);
    }
}
