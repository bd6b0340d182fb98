//! Whole updates of the actuator's program: the bootloader's ELF starts the program's ELF, which
//! takes the next image while it drives.

use board_tests::download::{Answer, Client, IDENTITY, INSTALL, STATUS, send};
use board_tests::frames::control;
use board_tests::master::{ENABLED_TICK, PERIODS, driven};
use board_tests::native::NativeBoard;
use board_tests::slots::{actuator_image, installed, requested, run_boot, slot_holds};
use bootloader::{Header, Outcome};
use canopen::Abort;
use virtual_board::faults::{Fault, Planned, Trigger};
use virtual_board::flash::FlashTimes;
use virtual_board::plant::{BoardPlantOptions, EncoderWire, Stuck};
use virtual_board::run::{Flow, Options, Script, View};

/// The angle that is held during the download, mdeg.
const HELD_MDEG: i32 = 20_000;

/// Control periods from the first target until the shaft holds: 2 s.
const HOLDING_TICK: u64 = ENABLED_TICK + 500;

/// Steps of an update.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Step {
    /// The drive is enabled and moves to the angle.
    Enable,
    /// 1F51h with nothing staged, and power.
    InstallTooEarly,
    Download,
    Staging,
    /// 1F51h while the drive holds the angle.
    InstallEnabled,
    /// The drive moves to another angle, then loses its power: from this tick on.
    Move(u64),
    InstallMoving,
    /// The shaft comes to rest: from this tick on.
    Rest(u64),
    Install,
    /// The board restarts with this many resets before.
    Restart(usize),
    /// The new program has booted at this time, ns.
    Trial(u64),
    Identity,
    Status,
}

/// A master that holds the surface while it updates the node.
#[derive(Debug)]
struct Update {
    image: Vec<u8>,
    client: Client,
    step: Step,
    period: u64,
    /// Ticks from the begin of the download to the end of the staging.
    staged: (u64, u64),
    identity: u32,
    status: u32,
    is_installed: bool,
    is_moving: bool,
}

impl Update {
    fn new(image: Vec<u8>) -> Self {
        Self {
            image,
            client: Client::default(),
            step: Step::Enable,
            period: 0,
            staged: (0, 0),
            identity: 0,
            status: 0,
            is_installed: false,
            is_moving: false,
        }
    }

    fn tick(&self) -> u64 {
        self.period / PERIODS
    }

    fn ask(&mut self, view: &mut View<'_>, request: [u8; 8], step: Step) {
        self.step = step;
        self.client.ask(view, request);
    }

    /// What is to be done when no answer is awaited.
    fn idle(&mut self, view: &mut View<'_>) {
        let tick = self.tick();
        match self.step {
            Step::Enable if tick >= HOLDING_TICK => {
                self.ask(view, INSTALL, Step::InstallTooEarly);
            }
            Step::Move(from) if tick >= from + 12 => {
                send(view, control(0, 0));
                self.ask(view, INSTALL, Step::InstallMoving);
            }
            Step::Rest(from) if tick >= from + 250 => self.ask(view, INSTALL, Step::Install),
            Step::Restart(resets) if view.resets() > resets => {
                if let Some(at_ns) = self.client.boot_ups.get(1) {
                    self.step = Step::Trial(*at_ns);
                }
            }
            Step::Trial(from_ns) if view.now_ns() > from_ns + 1_500_000_000 => {
                self.ask(view, IDENTITY, Step::Identity);
            }
            _ => {}
        }
    }

    fn answered(&mut self, view: &mut View<'_>, answer: Answer) -> Flow {
        let tick = self.tick();
        let refused = Answer::Aborted(Abort::DeviceState.code());
        match self.step {
            Step::InstallTooEarly => {
                assert_eq!(answer, refused, "it has power");
                self.staged.0 = tick;
                self.step = Step::Download;
                let image = self.image.clone();
                self.client.load(view, &image);
            }
            Step::Download => {
                assert_eq!(answer, Answer::Done(0), "the image fits");
                self.ask(view, STATUS, Step::Staging);
            }
            Step::Staging => match answer {
                Answer::Done(status) if status & 1 != 0 => self.ask(view, STATUS, Step::Staging),
                Answer::Done(status) => {
                    assert_eq!(status, 0, "staged without an error");
                    self.staged.1 = tick;
                    self.ask(view, INSTALL, Step::InstallEnabled);
                }
                Answer::Aborted(_) => panic!("{answer:?}"),
            },
            Step::InstallEnabled => {
                assert_eq!(answer, refused, "it has power");
                self.step = Step::Move(tick);
            }
            Step::InstallMoving => {
                assert_eq!(answer, refused, "it moves");
                self.is_moving = true;
                self.step = Step::Rest(tick);
            }
            Step::Install => {
                assert_eq!(answer, Answer::Done(0));
                self.step = Step::Restart(view.resets());
            }
            Step::Identity => {
                if let Answer::Done(identity) = answer {
                    self.identity = identity;
                }
                self.ask(view, STATUS, Step::Status);
            }
            Step::Status => {
                if let Answer::Done(status) = answer {
                    self.status = status;
                }
                self.is_installed = slot_holds(view, &self.image);
                return Flow::End;
            }
            _ => {}
        }
        Flow::Continue
    }

    fn proceed(&mut self, view: &mut View<'_>) -> Flow {
        match self.client.poll(view) {
            Some(answer) => self.answered(view, answer),
            None if self.client.is_busy() => Flow::Continue,
            None => {
                self.idle(view);
                Flow::Continue
            }
        }
    }
}

/// What the master sends for the drive at the begin of a tick, before it moves for the last time.
fn held(tick: u64) -> Vec<board_tests::frames::Frame> {
    driven(tick, HELD_MDEG)
}

impl Script for Update {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        if self.period.is_multiple_of(PERIODS) {
            let tick = self.tick();
            let frames = match self.step {
                Step::Move(from) if tick >= from && tick.is_multiple_of(5) => {
                    vec![control(0x0f, -HELD_MDEG)]
                }
                Step::Move(_) => Vec::new(),
                step if step < Step::Move(0) => held(tick),
                _ => Vec::new(),
            };
            for frame in frames {
                send(view, frame);
            }
        }
        self.period += 1;
        self.proceed(view)
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        self.proceed(view)
    }
}

/// The master sends each block as fast as the bus takes it: during the download the bus is full.
#[test]
fn a_program_is_replaced_by_the_next_one_which_it_takes_while_it_holds_the_surface() {
    let (old, new) = (actuator_image("1.0.0"), actuator_image("1.0.1"));
    let plant = BoardPlantOptions::default();
    let options = Options {
        contents: installed(&old),
        flash_times: FlashTimes::SHORT_ERASE,
        plant,
        ..Options::for_ms(60_000)
    };
    let finished = run_boot(options, Update::new(new.clone()));
    let script = &finished.script;
    assert_eq!(script.step, Step::Status);
    assert!(script.is_moving && script.is_installed);
    let header = Header::read(&new).expect("an image");
    assert_eq!(script.identity, header.identity());
    assert_eq!(script.status, (Outcome::Confirmed as u32) << 16);
    // One restart, which the program has requested.
    assert_eq!(finished.resets.len(), 1, "{:?}", finished.resets);

    // Up to the end of the staging the plant is that of a drive which only holds, bit for bit.
    let (begin, end) = script.staged;
    println!("loaded and staged in {} ms", 4 * (end - begin));
    let mut native = NativeBoard::new(&plant);
    (0..end).for_each(|tick| native.tick(&held(tick)));
    native.assert_same(&finished.trace.rows);
    let rows = (PERIODS * begin) as usize..(PERIODS * end) as usize;
    let angles = finished.trace.rows[rows].iter().map(|row| row.angle_deg);
    let (least, most) = angles.fold((f64::MAX, f64::MIN), |(a, b), deg| (a.min(deg), b.max(deg)));
    // One count of the encoder.
    assert!(most - least <= 360.0 / 4096.0, "{least} to {most} deg");
}

/// Runs until the board has started again after its trials.
#[derive(Debug)]
struct Trials {
    old: Vec<u8>,
    client: Client,
    is_planned: bool,
    status: Option<u32>,
    holds_old: bool,
}

impl Trials {
    fn proceed(&mut self, view: &mut View<'_>) -> Flow {
        if !self.is_planned {
            self.is_planned = true;
            let line = EncoderWire::Data;
            let stuck = Stuck::Low;
            view.plan(Planned {
                trigger: Trigger::At { ns: 0 },
                for_ns: None,
                fault: Fault::EncoderWire { line, stuck },
            });
        }
        match self.client.poll(view) {
            Some(Answer::Done(status)) => {
                self.status = Some(status);
                self.holds_old = slot_holds(view, &self.old);
                return Flow::End;
            }
            Some(answer) => panic!("{answer:?}"),
            None if self.client.boot_ups.len() > 3 && !self.client.is_busy() => {
                self.client.ask(view, STATUS);
            }
            None => {}
        }
        Flow::Continue
    }
}

impl Script for Trials {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        self.proceed(view)
    }

    fn at_poll(&mut self, view: &mut View<'_>) -> Flow {
        self.proceed(view)
    }
}

#[test]
fn a_program_that_fails_its_self_test_three_times_is_rolled_back() {
    let (old, new) = (actuator_image("1.0.0"), actuator_image("1.0.1"));
    let options = Options {
        contents: requested(&old, &new),
        flash_times: FlashTimes::SHORT_ERASE,
        ..Options::for_ms(60_000)
    };
    let script = Trials {
        old,
        client: Client::default(),
        is_planned: false,
        status: None,
        holds_old: false,
    };
    let finished = run_boot(options, script);
    assert_eq!(
        finished.script.status,
        Some((Outcome::RolledBack as u32) << 16)
    );
    assert!(finished.script.holds_old);
    assert_eq!(finished.resets.len(), 3, "{:?}", finished.resets);
}
