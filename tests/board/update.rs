//! Updates by the bootloader on the emulated board.

use board_tests::download::{Answer, Client, INSTALL};
use board_tests::frames::{Frame, from_wire, standard, to_wire};
use board_tests::slots::{MARK, NEW, OLD, image, installed, program, run_boot};
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
