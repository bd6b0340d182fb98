//! A program of a few instructions in the flash, which continues in the RAM, on cores that are used
//! one after the other.

use rigless::device::Level;
use rigless::emulator::{Access, CoreBus, Exit, InterruptLine, Processor, Queued};
use rigless::soc::Endian;
use rigless::time::VirtualNanos;

use super::{CoreKind, PAGE, Page, count};
use crate::board::{CORE_HZ, Sleep, core, resettable::Resettable};
use crate::chip::Chip;
use crate::flash::FlashTimes;

const FLASH: u64 = 0x0800_0000;
const RAM: u64 = 0x2000_0000;

/// A bus without devices.
struct NoDevices;

impl CoreBus for NoDevices {
    fn access(&mut self, _: Access, _: bool) -> Option<u64> {
        None
    }

    fn time(&self, instructions: u64) -> VirtualNanos {
        VirtualNanos(instructions)
    }

    fn queued(&mut self) -> Vec<Queued> {
        Vec::new()
    }
}

/// The kind of a test, whose cores no other test uses.
fn kind(test: &'static str) -> CoreKind {
    CoreKind {
        chip: test,
        clock_hz: CORE_HZ,
        vector_table: None,
        protects_memory: false,
    }
}

/// A run; its memory is dropped after its core.
struct Run {
    core: Box<dyn Processor>,
    chip: Chip,
    sleep: Sleep,
    _memory: [Vec<Page>; 2],
}

fn page(halves: &[u16]) -> Vec<Page> {
    let mut page = Page([0; PAGE]);
    for (place, half) in page.0.chunks_mut(2).zip(halves) {
        place.copy_from_slice(&half.to_le_bytes());
    }
    vec![page]
}

impl Run {
    /// A core at the start of a program that adds these two numbers in R0, the first in the flash,
    /// the second in the RAM.
    fn new(kind: CoreKind, [first, second]: [u16; 2]) -> Self {
        let chip = Chip::try_new(None, FlashTimes::TYPICAL, 0).unwrap();
        let plain = core::spec(&chip, &kind).unwrap().processor;
        let sleep = Sleep::default();
        let constructor = Resettable::constructor(kind, plain, None, None, sleep.clone());
        let mut core = constructor(Endian::Little).unwrap();
        let program = [
            // Stack at the end of the RAM's page, start at FLASH + 8.
            (RAM + PAGE as u64) as u16,
            (RAM >> 16) as u16,
            (FLASH + 8 + 1) as u16,
            (FLASH >> 16) as u16,
            0x2000 | first, // movs r0, #first
            0x4901,         // ldr r1, [pc, #4]
            0x4708,         // bx r1
            0xbf00,         // nop
            (RAM + 1) as u16,
            (RAM >> 16) as u16,
        ];
        // adds r0, #second; b .
        let mut memory = [page(&program), page(&[0x3000 | second, 0xe7fe])];
        let places = [(FLASH, false), (RAM, true)];
        for ((start, is_writable), pages) in places.into_iter().zip(&mut memory) {
            #[allow(unsafe_code, reason = "the memory outlives the core")]
            // SAFETY: the memory is on the heap, is dropped after the core, and is not used.
            unsafe {
                core.map(start, PAGE as u64, pages.as_mut_ptr().cast(), is_writable);
            }
        }
        let words: Vec<u16> = program.to_vec();
        core.boot(FLASH, &move |address, _| {
            let half = ((address - FLASH) / 2) as usize;
            Some(u64::from(words[half]) | u64::from(words[half + 1]) << 16)
        });
        Self {
            core,
            chip,
            sleep,
            _memory: memory,
        }
    }

    /// Until when the program cannot act if the run stops next at 700 ns.
    fn quiet_until_ns(&self, has_acted: bool) -> u64 {
        self.sleep.quiet_until_ns(&self.chip, has_acted, 700)
    }

    /// Runs the program to its end, a branch to itself, and returns R0.
    fn finish(&mut self) -> u32 {
        let (exit, _) = self.core.run(100, &mut NoDevices);
        assert_eq!(exit, Exit::Waiting);
        let bytes = self.core.gdb_register(0).unwrap();
        u32::from_le_bytes(bytes.try_into().unwrap())
    }
}

#[test]
fn a_core_that_is_used_again_executes_the_bytes_of_its_own_run() {
    let kind = kind("again");
    for (runs, [first, second]) in [[1, 2], [1, 2], [40, 2], [40, 7], [1, 2]]
        .into_iter()
        .enumerate()
    {
        assert_eq!(count(kind), usize::from(runs > 0));
        let mut run = Run::new(kind, [first, second]);
        assert_eq!(run.finish(), u32::from(first + second));
        assert_eq!(count(kind), 0, "the core was not taken");
    }
}

#[test]
fn the_state_after_a_run_is_that_of_a_new_core() {
    let kind = kind("state");
    let end = || {
        let mut run = Run::new(kind, [3, 4]);
        run.finish();
        (run.core.save(), run.core.retired())
    };
    let (on_a_new_core, again) = (end(), end());
    assert_eq!(on_a_new_core, again);
    // Four before the branch; it does not count from run to run.
    assert!((4..100).contains(&again.1), "{}", again.1);
}

#[test]
fn a_core_is_quiet_while_it_waits_until_an_interrupt_is_requested() {
    let mut run = Run::new(kind("sleep"), [1, 2]);
    assert_eq!(run.quiet_until_ns(false), 0);
    run.finish();
    assert_eq!(
        [run.quiet_until_ns(false), run.quiet_until_ns(true)],
        [700, 0]
    );
    let line = InterruptLine::new(3).unwrap();
    run.core.ask(Queued::Line(line, Level::High));
    assert_eq!(run.quiet_until_ns(false), 0);
}

#[test]
fn a_breakpoint_ends_with_its_run_and_one_of_the_next_run_is_met() {
    let kind = kind("breakpoint");
    let mut run = Run::new(kind, [1, 2]);
    run.finish();
    assert!(run.core.add_breakpoint(FLASH + 12));
    drop(run);
    let mut run = Run::new(kind, [1, 2]);
    assert_eq!(run.finish(), 3);
    drop(run);
    let mut run = Run::new(kind, [1, 2]);
    assert!(run.core.add_breakpoint(FLASH + 12));
    assert_eq!(run.core.run(100, &mut NoDevices), (Exit::Breakpoint, 2));
    assert_eq!(count(kind), 0);
}

#[test]
fn a_core_with_settings_of_its_run_is_not_used_again() {
    type Setting = fn(&mut dyn Processor);
    let settings: [(&str, Setting); 4] = [
        ("routed", |core| core.ask(Queued::Route(RAM))),
        ("debugged", |core| core.attach_debugger(true)),
        ("held", |core| core.hold_interrupts(true)),
        ("passing", |core| core.pass_breakpoint(FLASH)),
    ];
    for (name, set) in settings {
        let kind = kind(name);
        let mut run = Run::new(kind, [1, 2]);
        run.finish();
        set(&mut *run.core);
        drop(run);
        assert_eq!(count(kind), 0, "{name}");
    }
}
