//! Instructions between two symbols of a program, on an emulated STM32F427 without peripherals of a
//! board.

use std::{num::NonZeroU32, num::NonZeroU64, path::Path};

use rigless::{
    cpu,
    emulator::{self, Driver, Host, Settled, Start, Stop, Watch},
    image::Image,
    machine::{Board, Target, armv7m},
    mcu::{Mcu, Operate},
    session::Session,
    soc::{Width, stm32f427::Stm32f427},
    symbols::Symbols,
    time::VirtualNanos,
};

const CORE_HZ: u64 = 168_000_000;

/// The bare processor.
#[derive(Debug)]
struct Bare {
    mcu: Stm32f427,
}

rigless::store!(Bare {
    values: [],
    parts: [mcu],
    built: []
});

impl Board for Bare {
    fn name(&self) -> &'static str {
        "bare"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec!["stm32f427"]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn Mcu> {
        (target == 0).then_some(&mut self.mcu)
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = u32::from(Operate::cpu(&self.mcu).interrupt_lines);
        let core = armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: NonZeroU64::new(CORE_HZ).expect("not zero"),
            interrupt_lines: NonZeroU32::new(lines).expect("not zero"),
            priority_bits: 4,
            refclk_divider: NonZeroU32::new(8).expect("not zero"),
            instructions_per_second: NonZeroU64::new(CORE_HZ).expect("not zero"),
            boot: "flash",
        };
        let windows = cpu::armv7m::windows(Mcu::bus(&self.mcu));
        let spec = core.spec_with_parts(&windows, armv7m::Fpu::FpV4Sp, armv7m::MpuRegions::Eight);
        vec![Target::new("stm32f427", &mut self.mcu, spec)]
    }
}

/// The result of the count.
#[derive(Debug, Default)]
pub struct Counted {
    /// Instructions of each pass.
    pub instructions: Vec<u64>,
    /// Result of each pass.
    pub results: Vec<i32>,
}

struct Counter {
    from: u64,
    to: u64,
    /// Address of the program's result.
    result: u64,
    passes: usize,
    began: Option<u64>,
    is_watching: bool,
    counted: Counted,
}

impl Driver<Bare> for Counter {
    fn on_settled(&mut self, _: &mut Session<Bare>, host: &mut dyn Host, settled: Settled) {
        let Settled::Hit(hit) = settled else { return };
        if hit.address == self.from {
            self.began = Some(hit.instruction_count);
        } else if let Some(began) = self.began.take() {
            let instructions = hit.instruction_count - began;
            self.counted.instructions.push(instructions);
            let result = host.read(self.result, Width::W32).expect("memory");
            self.counted.results.push(result as i32);
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Bare>,
        stop: Stop,
        _: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        if !self.is_watching {
            self.is_watching = true;
            session.watch(Watch::Instruction(self.from));
            session.watch(Watch::Instruction(self.to));
        }
        let done = self.counted.instructions.len() >= self.passes;
        (!done).then(|| VirtualNanos(stop.at.0 + 100_000))
    }
}

/// Counts the instructions from each execution of one symbol to the next execution of another,
/// where it reads a variable, the result.
///
/// # Panics
/// If the file is not such a program.
pub fn count(elf: &Path, [from, to]: [&str; 2], result: &str, passes: usize) -> Counted {
    let bytes = std::fs::read(elf).expect("the program");
    let symbols = Symbols::read(&bytes, |address| address & !1).expect("its symbols");
    let address = |name: &str| symbols.get(name).unwrap_or_else(|_| panic!("no {name}")) & !1;
    let counter = Counter {
        from: address(from),
        to: address(to),
        result: symbols.get(result).expect("the variable of the result"),
        passes,
        began: None,
        is_watching: false,
        counted: Counted::default(),
    };
    let board = Bare {
        mcu: Stm32f427::new().expect("the processor"),
    };
    // Before the first instruction of the program, so that every pass is counted.
    let first_stop = VirtualNanos(1);
    let session = Session::new(Box::new(board), 0, first_stop).expect("a session");
    let images = [Image::read(elf, None).expect("an image")];
    let finished = emulator::run(session, &Start::new(&images), counter).expect("a run");
    finished.driver.counted
}
