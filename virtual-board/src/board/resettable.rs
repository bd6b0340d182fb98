//! A core that keeps its translated code over a reset, and leaves it to the next run.
//!
//! The emulator's core drops all translated code when it resets, and translating the program again
//! takes longer than running its first hundred milliseconds. The code stays valid: a reset does not
//! change the flash, and every write to memory invalidates what was translated from it. So a
//! second core is reset instead, and its state is loaded into the first one, which keeps its code.
//! After its run the core is kept for another one ([`spare_cores`]).

use std::ops::Range;

use rigless::emulator::{
    BitAlias, CoreBus, DataModel, Error, Exit, HaltReason, HostCall, Processor,
    ProcessorConstructor, Queued,
};
use rigless::soc::{Endian, Width};
use rigless::time::VirtualNanos;

use super::crc_bus::{CrcBus, CrcPort};
use super::sleep::Sleep;
use super::spare_cores::{self, CoreKind};
use crate::chip::Remainder;
use crate::processor::{Memory, RegisterWrite, SharedObserver, lock};

/// A core, and another one of the same kind that computes its state after a reset.
#[derive(Debug)]
pub(super) struct Resettable {
    kind: CoreKind,
    core: Box<dyn Processor>,
    /// It has no memory and executes nothing. There is one until the run ends.
    twin: Option<Box<dyn Processor>>,
    /// The core has executed instructions in this run.
    has_run: bool,
    /// A debugger may halt the core at its reset, which is not a part of the loaded state.
    is_debugged: bool,
    /// The core has settings that are not a part of the loaded state and cannot be taken back.
    is_altered: bool,
    /// Addresses at which the run has the core stop, once for each request.
    breakpoints: Vec<u64>,
    /// The core is to pass a breakpoint when it runs again.
    is_passing: bool,
    memory: Memory,
    observer: Option<SharedObserver>,
    crc: Option<CrcPort>,
    sleep: Sleep,
}

impl Resettable {
    /// Makes the constructor of a core one of a core that keeps its translated code.
    pub fn constructor(
        kind: CoreKind,
        inner: ProcessorConstructor,
        observer: Option<SharedObserver>,
        crc: Option<Remainder>,
        sleep: Sleep,
    ) -> ProcessorConstructor {
        std::sync::Arc::new(move |endian| {
            Ok(Box::new(Self {
                kind,
                core: inner(endian)?,
                twin: Some(inner(endian)?),
                has_run: false,
                is_debugged: false,
                is_altered: false,
                breakpoints: Vec::new(),
                is_passing: false,
                memory: Memory::default(),
                observer: observer.clone(),
                crc: crc.clone().map(CrcPort::new),
                sleep: sleep.clone(),
            }))
        })
    }

    /// Loads the state after a reset; fails if the emulator refuses a state.
    fn load_reset_state(&mut self) -> Result<(), Error> {
        let twin = self.twin.as_mut().ok_or(Error::State)?;
        twin.load(&self.core.save())?;
        twin.reset();
        self.core.load(&twin.save())
    }

    /// Before the first instruction: continues on a core that has translated the program before.
    fn take_spare(&mut self) {
        self.has_run = true;
        if self.is_debugged || self.is_altered {
            return;
        }
        if let Some(Ok(mut core)) = spare_cores::take(self.kind, &self.memory, &self.core.save()) {
            for address in &self.breakpoints {
                core.add_breakpoint(*address);
            }
            self.core = core;
        }
    }

    /// Writes registers by way of the second core: the emulator drops all translated code with a
    /// register that is written.
    fn write_registers(&mut self, writes: &[RegisterWrite]) {
        let Some(twin) = &mut self.twin else {
            return;
        };
        let loaded = twin.load(&self.core.save());
        debug_assert!(loaded.is_ok(), "both cores are of one kind");
        for (number, word) in writes {
            twin.set_gdb_register(*number, &word.to_le_bytes());
        }
        let loaded = self.core.load(&twin.save());
        debug_assert!(loaded.is_ok(), "both cores are of one kind");
    }
}

impl Drop for Resettable {
    /// The emulator drops the core before the memory that it maps.
    fn drop(&mut self) {
        let is_as_new = self.has_run && !self.is_altered && !self.is_passing;
        if !is_as_new || std::thread::panicking() {
            return;
        }
        if let Some(twin) = self.twin.take() {
            let mut core = std::mem::replace(&mut self.core, twin);
            for address in &self.breakpoints {
                core.remove_breakpoint(*address);
            }
            spare_cores::keep(self.kind, core, &self.memory);
        }
    }
}

impl Processor for Resettable {
    fn reset(&mut self) {
        self.sleep.end();
        if self.is_debugged || self.load_reset_state().is_err() {
            self.core.reset();
        }
        // A request that is still pending ends with the reset.
        self.core.take_reset_request();
        if let Some(crc) = &mut self.crc {
            crc.close();
        }
        if let Some(observer) = &self.observer {
            lock(observer).after_reset();
        }
    }

    fn attach_debugger(&mut self, attached: bool) {
        self.is_debugged = attached;
        self.is_altered = true;
        self.core.attach_debugger(attached);
    }

    #[allow(
        unsafe_code,
        reason = "the trait declares the function unsafe; the call is forwarded unchanged"
    )]
    unsafe fn map(&mut self, start: u64, length: u64, host: *mut u8, writable: bool) {
        // SAFETY: the caller's promise covers the core and this value's view of the memory, which
        // are dropped with this value.
        unsafe {
            self.core.map(start, length, host, writable);
            self.memory.map(start, length, host, writable);
        }
    }

    // Everything else is the core's.

    fn run(&mut self, budget: u32, bus: &mut dyn CoreBus) -> (Exit, u64) {
        if !self.has_run {
            self.take_spare();
        }
        self.is_passing = false;
        let end = self.core.retired() + u64::from(budget);
        let mut front;
        let bus: &mut dyn CoreBus = match &mut self.crc {
            None => bus,
            Some(port) => {
                front = CrcBus::new(bus, port, end);
                &mut front
            }
        };
        let result = match &self.observer {
            None => self.core.run(budget, bus),
            Some(observer) => {
                let mut observer = lock(observer);
                let result = observer.run(&mut *self.core, &self.memory, budget, bus);
                let writes = observer.take_register_writes();
                drop(observer);
                if !writes.is_empty() {
                    self.write_registers(&writes);
                }
                result
            }
        };
        match result {
            (Exit::Waiting, _) => self.sleep.begin(self.core.next_event()),
            _ => self.sleep.end(),
        }
        result
    }

    fn retired(&self) -> u64 {
        self.core.retired()
    }

    fn ask(&mut self, queued: Queued) {
        self.is_altered |= matches!(queued, Queued::Route(_) | Queued::Unroute(_));
        self.sleep.end();
        self.core.ask(queued);
    }

    fn maps(&self, start: u64, length: u64) -> bool {
        self.core.maps(start, length)
    }

    fn page_size(&self) -> u64 {
        self.core.page_size()
    }

    fn boot(&mut self, table: u64, read: &dyn Fn(u64, Width) -> Option<u64>) {
        self.core.boot(table, read);
    }

    fn take_reset_request(&mut self) -> bool {
        self.core.take_reset_request()
    }

    fn next_event(&self) -> Option<VirtualNanos> {
        self.core.next_event()
    }

    fn on_event(&mut self, now: VirtualNanos) {
        self.sleep.end();
        self.core.on_event(now);
    }

    fn waiting(&self) -> bool {
        self.core.waiting()
    }

    fn pc(&self) -> u64 {
        self.core.pc()
    }

    fn add_breakpoint(&mut self, address: u64) -> bool {
        let is_added = self.core.add_breakpoint(address);
        if is_added {
            self.breakpoints.push(address);
        }
        is_added
    }

    fn remove_breakpoint(&mut self, address: u64) {
        if let Some(index) = self.breakpoints.iter().position(|one| *one == address) {
            self.breakpoints.swap_remove(index);
        }
        self.core.remove_breakpoint(address);
    }

    fn pass_breakpoint(&mut self, address: u64) {
        self.is_passing = true;
        self.core.pass_breakpoint(address);
    }

    fn hold_interrupts(&mut self, held: bool) {
        self.is_altered = true;
        self.core.hold_interrupts(held);
    }

    fn gdb_register(&self, number: usize) -> Option<Vec<u8>> {
        self.core.gdb_register(number)
    }

    fn set_gdb_register(&mut self, number: usize, bytes: &[u8]) -> bool {
        self.core.set_gdb_register(number, bytes)
    }

    fn debugger_access(
        &mut self,
        write: Option<u64>,
        address: u64,
        width: Width,
        now: VirtualNanos,
    ) -> Option<u64> {
        self.core.debugger_access(write, address, width, now)
    }

    fn take_debugger_trace(&mut self) -> Vec<u8> {
        self.core.take_debugger_trace()
    }

    fn target_xml(&self) -> &'static str {
        self.core.target_xml()
    }

    fn data_model(&self) -> DataModel {
        self.core.data_model()
    }

    fn byte_order(&self, address: u64) -> Endian {
        self.core.byte_order(address)
    }

    fn save(&self) -> Vec<u8> {
        self.core.save()
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.core.load(bytes)
    }

    fn monitor_command(&mut self, command: &str) -> Option<String> {
        self.core.monitor_command(command)
    }

    fn debugger_halted(&mut self, why: HaltReason) -> bool {
        self.core.debugger_halted(why)
    }

    fn bit_alias(&self, address: u64, width: Width) -> Option<BitAlias> {
        self.core.bit_alias(address, width)
    }

    fn own_ranges(&self) -> Vec<Range<u64>> {
        self.core.own_ranges()
    }

    fn check_reads(&mut self, every: bool) {
        self.is_altered = true;
        self.core.check_reads(every);
    }

    fn check_words(&mut self, words: &[u64]) {
        self.is_altered = true;
        self.core.check_words(words);
    }

    fn host_call(&self, read: &mut dyn FnMut(u64, Width) -> Option<u64>) -> Option<HostCall> {
        self.core.host_call(read)
    }

    fn answer_host_call(&mut self, answer: Option<u64>) {
        self.core.answer_host_call(answer);
    }
}

#[cfg(test)]
mod tests {
    use rigless::device::Level;
    use rigless::emulator::InterruptLine;

    use super::*;
    use crate::board::{CORE_HZ, core};
    use crate::chip::Chip;
    use crate::flash::FlashTimes;

    const KIND: CoreKind = CoreKind {
        chip: "reset",
        clock_hz: CORE_HZ,
        vector_table: None,
        protects_memory: false,
    };

    #[test]
    fn the_state_after_a_reset_is_that_of_the_emulators_core() {
        let chip = Chip::try_new(None, FlashTimes::TYPICAL, 0).unwrap();
        let plain = core::spec(&chip, &KIND).unwrap().processor;
        let constructors = [
            plain.clone(),
            Resettable::constructor(KIND, plain, None, None, Sleep::default()),
        ];
        let [expected, found] = constructors.map(|constructor| {
            let mut core = constructor(Endian::Little).unwrap();
            let unused = core.save();
            core.boot(0x0800_0000, &|address, _| Some(address + 0x100));
            for number in 0..13 {
                assert!(core.set_gdb_register(number, &[number as u8 + 1; 4]));
            }
            core.ask(Queued::Line(InterruptLine::new(37).unwrap(), Level::High));
            let used = core.save();
            core.reset();
            assert!(core.save() != used && used != unused);
            core.save()
        });
        assert_eq!(found, expected);
    }
}
