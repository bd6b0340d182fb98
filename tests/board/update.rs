//! Updates by the bootloader on the emulated board.

use board_tests::download::{Answer, Client, INSTALL};
use board_tests::frames::{Frame, from_wire, standard, to_wire};
use board_tests::slots::{
    MARK, NEW, OLD, image, installed, program, requested, run_boot, slot_holds,
};
use bootloader::layout::STM32F427;
use virtual_board::faults::{Fault, Planned, Trigger};
use virtual_board::flash::FlashTimes;
use virtual_board::run::{Flow, Options, Script, View};

/// Words behind the program, so that an image is of some size.
const PADDING: usize = 16;

/// The marks of the programs that ran, each with its time, ns.
#[derive(Debug, Default)]
struct Marks(Vec<(u64, u32)>);

impl Marks {
    fn note(&mut self, view: &mut View<'_>) {
        let mark = view.word(MARK).filter(|mark| [OLD, NEW].contains(mark));
        if let Some(mark) = mark.filter(|mark| self.0.last().is_none_or(|last| last.1 != *mark)) {
            self.0.push((view.now_ns(), mark));
        }
    }

    fn order(&self) -> Vec<u32> {
        self.0.iter().map(|(_, mark)| *mark).collect()
    }
}

fn old_image() -> Vec<u8> {
    image(&program(OLD, PADDING), "1.0.0")
}

fn new_image() -> Vec<u8> {
    image(&program(NEW, PADDING), "1.0.1")
}

/// How long the bootloader takes to start a program of the size of the actuator's, ns of the
/// emulator's time, which is 168 instructions in a microsecond.
fn start_ns(contents: Vec<(u64, Vec<u8>)>) -> u64 {
    let options = Options {
        contents,
        ..Options::for_ms(1_000)
    };
    let first = |marks: &mut Marks, view: &mut View<'_>| {
        marks.note(view);
        if marks.0.is_empty() {
            Flow::Continue
        } else {
            Flow::End
        }
    };
    struct Start<F>(Marks, F);
    impl<F: FnMut(&mut Marks, &mut View<'_>) -> Flow + Send> Script for Start<F> {
        fn at_edge(&mut self, _: &mut View<'_>) -> Flow {
            Flow::Continue
        }
        fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
            (self.1)(&mut self.0, view)
        }
    }
    let finished = run_boot(options, Start(Marks::default(), first));
    finished.script.0.0.first().expect("the program runs").0
}

#[test]
fn a_start_after_power_on_checks_100_kb_in_less_than_a_million_instructions() {
    let old = image(&program(OLD, 25_000), "1.0.0");
    let instructions = start_ns(installed(&old)) * 168 / 1000;
    println!("{instructions} instructions");
    assert!(instructions < 1_000_000, "{instructions}");
}

/// Loads an image into a board without one, and has it installed.
#[derive(Debug, Default)]
struct Loading {
    marks: Marks,
    client: Client,
    is_loaded: bool,
}

impl Script for Loading {
    fn at_edge(&mut self, _: &mut View<'_>) -> Flow {
        Flow::Continue
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        self.marks.note(view);
        let answer = self.client.poll(view);
        let has_started = !self.client.boot_ups.is_empty();
        if answer.is_some() {
            assert_eq!(answer, Some(Answer::Done(0)));
        }
        if answer.is_some() && !self.is_loaded {
            self.is_loaded = true;
            self.client.ask(view, INSTALL);
        } else if has_started && !self.is_loaded && !self.client.is_busy() {
            self.client.load(view, &new_image());
        }
        if self.marks.0.is_empty() {
            Flow::Continue
        } else {
            Flow::End
        }
    }
}

#[test]
fn a_board_without_a_program_takes_an_image_over_the_bus_and_runs_it() {
    let finished = run_boot(Options::for_ms(10_000), Loading::default());
    assert_eq!(finished.script.marks.order(), [NEW]);
}

/// An LSS master that sets a waiting bootloader to 250 kbit/s, has it store that, and interrupts
/// its supply.
#[derive(Debug, Default)]
struct Slower {
    /// Time of the first boot-up, ns.
    start_ns: Option<u64>,
    step: usize,
    /// Frames that the node sent at the first and at the second bit rate.
    received: [Vec<Frame>; 2],
}

impl Slower {
    /// What to send through which port, at these times after the boot-up, ms.
    const REQUESTS: [(u64, usize, [u8; 4]); 4] = [
        (5, 0, [0x04, 1, 0, 0]),
        (10, 0, [0x13, 0, 3, 0]),
        (15, 0, [0x15, 20, 0, 0]),
        (100, 1, [0x17, 0, 0, 0]),
    ];

    /// The master leaves the first bit rate, and the supply is cut, at these times, ms.
    const SWITCH_MS: u64 = 25;
    const CUT_MS: u64 = 200;
    const END_MS: u64 = 600;
}

impl Script for Slower {
    fn at_edge(&mut self, _: &mut View<'_>) -> Flow {
        Flow::Continue
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        let now_ns = view.now_ns();
        let now_ms = self
            .start_ns
            .map_or(0, |start| (now_ns - start) / 1_000_000);
        let is_slow = now_ms >= Self::SWITCH_MS;
        for (number, received) in self.received.iter_mut().enumerate() {
            let Some(port) = view.port(number) else {
                return Flow::End;
            };
            port.is_silent = (number == 1) != is_slow;
            let frames = port.take_received();
            received.extend(frames.iter().map(|(_, frame)| from_wire(frame)));
        }
        if self.start_ns.is_none() && !self.received[0].is_empty() {
            self.start_ns = Some(now_ns);
        }
        match Self::REQUESTS.get(self.step) {
            Some((at_ms, number, bytes)) if now_ms >= *at_ms => {
                let [a, b, c, d] = *bytes;
                let frame = standard(0x7e5, &[a, b, c, d, 0, 0, 0, 0]);
                if let Some(port) = view.port(*number) {
                    port.send(now_ns, to_wire(&frame));
                }
                self.step += 1;
            }
            None if now_ms >= Self::CUT_MS && self.step == Self::REQUESTS.len() => {
                self.step += 1;
                view.plan(Planned {
                    trigger: Trigger::At { ns: now_ns },
                    for_ns: Some(2_000_000),
                    fault: Fault::PowerLoss,
                });
            }
            _ => {}
        }
        if now_ms < Self::END_MS {
            Flow::Continue
        } else {
            Flow::End
        }
    }
}

#[test]
fn a_waiting_bootloader_changes_its_bit_rate_by_lss_and_starts_with_it_again() {
    let options = Options {
        ports_bit_s: vec![1_000_000, 250_000],
        flash_times: FlashTimes::SHORT_ERASE,
        ..Options::for_ms(2_000)
    };
    let finished = run_boot(options, Slower::default());
    let [fast, slow] = finished.script.received;
    let lss = |frames: &[Frame]| -> Vec<[u8; 8]> {
        let frames = frames.iter().filter(|frame| frame.raw_id().0 == 0x7e4);
        frames.map(|frame| frame.bytes()).collect()
    };
    assert_eq!(lss(&fast), [[0x13, 0, 0, 0, 0, 0, 0, 0]]);
    assert_eq!(lss(&slow), [[0x17, 0, 0, 0, 0, 0, 0, 0]]);
    let boot_ups = |frames: &[Frame]| {
        let is_boot_up = |frame: &&Frame| frame.raw_id().0 == 0x701 && frame.bytes()[0] == 0;
        frames.iter().filter(is_boot_up).count()
    };
    assert_eq!([boot_ups(&fast), boot_ups(&slow)], [1, 1]);
}

/// Cuts the supply in one operation of an update after the other, and lets the board recover.
#[derive(Debug)]
struct Cuts {
    marks: Marks,
    before: Vec<(u64, u32)>,
    /// Operations of an update without a cut.
    operations: Option<usize>,
    cut: u64,
    recovered: usize,
}

/// Distance of the operations that are cut. With the environment variable `EXHAUSTIVE`, all are.
fn distance() -> u64 {
    if std::env::var_os("EXHAUSTIVE").is_some() {
        1
    } else {
        8
    }
}

impl Cuts {
    fn new() -> Self {
        Self {
            marks: Marks::default(),
            before: Vec::new(),
            operations: None,
            cut: 0,
            recovered: 0,
        }
    }

    /// The words that an update changes.
    fn words(view: &mut View<'_>) -> Vec<(u64, u32)> {
        let layout = &STM32F427;
        let regions = [
            layout.slot.start(),
            layout.staging.start(),
            layout.backup.start(),
        ];
        let starts = regions
            .into_iter()
            .chain(layout.records.map(|sector| sector.start));
        let addresses = starts.flat_map(|start| (start..start + 1024).step_by(4));
        let addresses: Vec<u64> = addresses.map(u64::from).collect();
        let read = |address: u64| (address, view.word(address).unwrap_or(0));
        addresses.into_iter().map(read).collect()
    }

    /// Restores the flash, and starts the update again with a cut.
    fn again(&mut self, view: &mut View<'_>) {
        for (address, word) in &self.before {
            if view.word(*address) != Some(*word) {
                assert!(view.program_word(*address, *word), "{address:#x} is flash");
            }
        }
        let now_ns = view.now_ns();
        let planned = |fault, for_ns| Planned {
            trigger: Trigger::At { ns: now_ns },
            for_ns,
            fault,
        };
        view.plan(planned(
            Fault::FlashCut {
                operation: self.cut,
                permille: 100 + self.cut * 97 % 800,
            },
            None,
        ));
        view.plan(planned(Fault::PowerLoss, Some(2_000_000)));
        self.marks = Marks::default();
    }
}

impl Script for Cuts {
    fn at_edge(&mut self, _: &mut View<'_>) -> Flow {
        Flow::Continue
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        if self.before.is_empty() {
            self.before = Self::words(view);
        }
        self.marks.note(view);
        if self.marks.order() != [NEW, OLD] {
            return Flow::Continue;
        }
        assert!(slot_holds(view, &old_image()), "cut in {}", self.cut);
        let log = view.flash().expect("an STM32F427").take_log();
        match self.operations {
            None => self.operations = Some(log.len()),
            Some(_) => {
                self.recovered += 1;
                self.cut += distance();
            }
        }
        if self.cut as usize >= self.operations.unwrap_or(0) {
            return Flow::End;
        }
        self.again(view);
        Flow::Continue
    }
}

#[test]
fn after_a_loss_of_supply_in_any_operation_of_an_update_the_board_runs_a_whole_image() {
    let options = Options {
        contents: requested(&old_image(), &new_image()),
        flash_times: FlashTimes::SHORT_ERASE,
        ..Options::for_ms(5_000_000)
    };
    let finished = run_boot(options, Cuts::new());
    let script = finished.script;
    println!(
        "{} operations, {} cuts, {} ms",
        script.operations.unwrap_or(0),
        script.recovered,
        finished.end_ns / 1_000_000
    );
    let expected = (script.operations.unwrap_or(0) as u64).div_ceil(distance());
    assert_eq!(script.recovered as u64, expected);
    assert!(expected > 10);
}
