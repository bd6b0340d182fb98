//! The supply is cut while the actuator's program stages an image on a full bus: the program that
//! ran before runs again, nothing that is not whole is installed, and the next download succeeds.
//!
//! The image is small, so that a cut takes a fraction of a second; its sectors and operations are
//! those of a large one.

use board_tests::download::{Answer, Client, IDENTITY, INSTALL, STATUS, send};
use board_tests::frames::{control, start};
use board_tests::slots::{NEW, actuator_image, image, installed, program, run_boot, slot_holds};
use bootloader::layout::STM32F427;
use bootloader::{HEADER_SIZE, Header};
use canopen::Abort;
use virtual_board::faults::{Fault, Planned, Trigger};
use virtual_board::flash::FlashTimes;
use virtual_board::run::{Flow, Options, Script, View};

/// Cuts at random; with the environment variable `EXHAUSTIVE` there is one in every operation.
const CUTS: usize = 24;

/// Time from boot-up until the program has started and is asked, ns.
const STARTED_NS: u64 = 60_000_000;

/// Commands that wait for the bus: more than it carries until the next PWM edge, 1 ms later. One of
/// 6 bytes has 95 bits with the intermission, without stuff bits, and takes 95 us or more.
const WAITING: usize = 16;

/// Words of the program in the image.
const WORDS: usize = 64;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// The board starts: this number of boot-ups is awaited.
    Start(usize),
    Load,
    /// The image is being staged until the supply is cut.
    Staging,
    Identity,
    Kept,
    Install,
    /// Without a cut: staged or not yet.
    Status,
}

#[derive(Debug)]
struct Cuts {
    old: Vec<u8>,
    new: Vec<u8>,
    client: Client,
    step: Step,
    /// The operations that are still to be cut, the last first.
    left: Vec<u64>,
    /// Whether the supply is cut in the present staging.
    is_cut: bool,
    random: Random,
    resets: usize,
    /// Cuts at which a command waited for the bus.
    on_full_bus: usize,
    refused: usize,
    whole: usize,
    is_staged: bool,
}

/// The generator SplitMix64.
#[derive(Debug)]
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ mixed >> 31) % end
    }
}

impl Cuts {
    fn new(old: Vec<u8>, new: Vec<u8>) -> Self {
        let mut random = Random(18);
        // An erase, and each word that is not erased.
        let words = new.as_chunks::<4>().0.iter();
        let operations = 1 + words.filter(|word| **word != [u8::MAX; 4]).count() as u64;
        let left = if std::env::var_os("EXHAUSTIVE").is_some() {
            (0..operations).collect()
        } else {
            let ends = [0, 1, operations - 1];
            let others = (ends.len()..CUTS).map(|_| random.below(operations));
            ends.into_iter().chain(others).collect()
        };
        Self {
            old,
            new,
            client: Client::default(),
            step: Step::Start(1),
            left,
            is_cut: false,
            random,
            resets: 0,
            on_full_bus: 0,
            refused: 0,
            whole: 0,
            is_staged: false,
        }
    }

    fn ask(&mut self, view: &mut View<'_>, request: [u8; 8], step: Step) {
        self.step = step;
        self.client.ask(view, request);
    }

    /// Loads the image, and cuts the supply in the next operation of the flash that is to be cut.
    fn load(&mut self, view: &mut View<'_>) {
        self.step = Step::Load;
        self.resets = view.resets();
        let operation = self.left.pop();
        self.is_cut = operation.is_some();
        if let Some(operation) = operation {
            let permille = self.random.below(1000);
            let ns = view.now_ns();
            view.plan(Planned {
                trigger: Trigger::At { ns },
                for_ns: None,
                fault: Fault::FlashCut {
                    operation,
                    permille,
                },
            });
        }
        let image = self.new.clone();
        self.client.load(view, &image);
    }

    fn answered(&mut self, view: &mut View<'_>, answer: Answer) -> Flow {
        match self.step {
            Step::Load => {
                assert_eq!(answer, Answer::Done(0), "the image fits");
                if self.is_cut {
                    self.step = Step::Staging;
                    send(view, start());
                    self.fill_bus(view);
                } else {
                    self.ask(view, STATUS, Step::Status);
                }
            }
            Step::Identity => {
                let old = Header::read(&self.old).expect("an image").identity();
                assert_eq!(answer, Answer::Done(old), "the program before runs");
                assert!(slot_holds(view, &self.old));
                let kept = [0x40, 0x04, 0x21, 1, 0, 0, 0, 0];
                self.ask(view, kept, Step::Kept);
            }
            Step::Kept if answer == Answer::Done(0) => self.ask(view, INSTALL, Step::Install),
            Step::Kept => {
                // The cut was in the last word, or after it.
                let new = Header::read(&self.new).expect("an image").identity();
                assert_eq!(answer, Answer::Done(new));
                assert!(staging_holds(view, &self.new));
                self.whole += 1;
                self.load(view);
            }
            Step::Install => {
                let refused = Answer::Aborted(Abort::DeviceState.code());
                assert_eq!(answer, refused, "nothing is staged");
                self.refused += 1;
                self.load(view);
            }
            Step::Status => match answer {
                Answer::Done(status) if status & 1 != 0 => self.ask(view, STATUS, Step::Status),
                _ => {
                    assert_eq!(answer, Answer::Done(0), "staged without an error");
                    self.is_staged = staging_holds(view, &self.new);
                    return Flow::End;
                }
            },
            Step::Start(_) | Step::Staging => {}
        }
        Flow::Continue
    }

    /// Fills the bus while the image is written.
    fn fill_bus(&self, view: &mut View<'_>) {
        while self.step == Step::Staging && waiting(view) < WAITING {
            send(view, control(0, 0));
        }
    }

    fn act(&mut self, view: &mut View<'_>) -> Flow {
        let is_staging = matches!(self.step, Step::Load | Step::Staging);
        if is_staging && view.resets() > self.resets {
            self.on_full_bus += usize::from(waiting(view) > 0);
            self.client.give_up();
            self.step = Step::Start(self.client.boot_ups.len() + 1);
        }
        match self.client.poll(view) {
            Some(answer) => self.answered(view, answer),
            None if self.client.is_busy() => Flow::Continue,
            None => {
                self.idle(view);
                Flow::Continue
            }
        }
    }

    fn idle(&mut self, view: &mut View<'_>) {
        let Step::Start(count) = self.step else {
            return;
        };
        let at_ns = self.client.boot_ups.get(count - 1);
        if at_ns.is_none_or(|at_ns| view.now_ns() < at_ns + STARTED_NS) {
            return;
        }
        if self.is_cut {
            self.ask(view, IDENTITY, Step::Identity);
        } else {
            self.load(view);
        }
    }
}

/// Frames of the master that wait for the bus.
fn waiting(view: &mut View<'_>) -> usize {
    view.port(0).map_or(0, |port| port.queued())
}

/// Whether the staging area holds this image.
fn staging_holds(view: &mut View<'_>, image: &[u8]) -> bool {
    let start = u64::from(STM32F427.staging.start());
    let words = image.as_chunks::<4>().0.iter();
    (start..)
        .step_by(4)
        .zip(words)
        .all(|(address, word)| view.word(address) == Some(u32::from_le_bytes(*word)))
}

impl Script for Cuts {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.fill_bus(view);
        self.act(view)
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        self.act(view)
    }
}

#[test]
fn after_a_loss_of_supply_while_it_stages_an_image_the_program_runs_and_stages_the_next_one() {
    let new = image(&program(NEW, WORDS), "1.0.1");
    assert!(new.len() > HEADER_SIZE as usize);
    let old = actuator_image("1.0.0");
    let options = Options {
        contents: installed(&old),
        flash_times: FlashTimes::SHORT_ERASE,
        ..Options::for_ms(1_000_000)
    };
    let finished = run_boot(options, Cuts::new(old, new));
    let script = finished.script;
    let (cuts, ms) = (script.refused + script.whole, finished.end_ns / 1_000_000);
    println!("{cuts} cuts in {ms} ms: {} images whole", script.whole);
    assert!(script.left.is_empty() && script.is_staged);
    assert_eq!(finished.resets.len(), cuts);
    assert_eq!(script.on_full_bus, cuts);
    assert!(cuts >= CUTS && script.refused >= CUTS - 2);
}
