//! Saves of parameters that the supply does not outlast, one after the other in a single run: the
//! emulator translates the program once.

use std::collections::VecDeque;

use firmware::parameters::BoardParameters;
use virtual_board::faults::{Fault, Planned, Trigger};
use virtual_board::flash::{Operation, Sector};
use virtual_board::run::{Flow, Script, View};

use crate::frames::{BoardFrame, Frame, order};

/// From power-on until the board has started and measured, ns.
const STARTED_NS: u64 = 60_000_000;

/// From a new value to the order to save it, and from question to question, ns.
const PAUSE_NS: u64 = 10_000_000;

/// More than any save takes, the erase of a page before it included, ns.
const SAVED_NS: u64 = 1_500_000_000;

/// How long the supply is gone between two saves, ns.
const DARK_NS: u64 = 2_000_000;

/// Where a save is cut: in which operation of the flash, and after how many thousandths of its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// Counted from the beginning of the save.
    pub operation: u64,
    /// Thousandths.
    pub permille: u64,
}

/// The two pages of parameters, word by word.
type Pages = Vec<u32>;

/// What is waited for, and since when, ns.
#[derive(Debug, Clone, Copy)]
enum Step {
    /// The board starts.
    Starting(u64),
    /// It has a new value, and is to save it.
    Writing(u64),
    /// It saves.
    Saving(u64),
    /// It has started again after the cut, or saved in peace, and is asked for its value.
    Asking(u64),
}

/// Saves so many times in peace. Then saves, again and again from the flash as it was before the
/// last of them, and cuts the supply each time.
pub struct Cuts {
    number: u8,
    values: Vec<u32>,
    choose: fn(&[Operation]) -> Vec<Cut>,
    cuts: VecDeque<Cut>,
    cut: Option<Cut>,
    peaceful: usize,
    before: Pages,
    step: Step,
    resets: usize,
    asked_ns: u64,
    /// What the board held after each cut.
    pub held: Vec<(Cut, u32)>,
}

impl Cuts {
    /// Saves `values` of the parameter of this name in peace, one after the other; `choose` makes the
    /// cuts from the operations of the last of these saves.
    ///
    /// # Panics
    /// If there is no such parameter, or no value.
    pub fn new(name: &str, values: &[u32], choose: fn(&[Operation]) -> Vec<Cut>) -> Self {
        let is_it = |number: &u8| {
            let meaning = BoardParameters::meaning(*number);
            meaning.is_some_and(|meaning| meaning.name() == name)
        };
        assert!(!values.is_empty());
        Self {
            number: (0..128).find(is_it).expect("it has a number"),
            values: values.to_vec(),
            choose,
            cuts: VecDeque::new(),
            cut: None,
            peaceful: 0,
            before: Pages::new(),
            step: Step::Starting(0),
            resets: 0,
            asked_ns: 0,
            held: Vec::new(),
        }
    }

    /// Whether every chosen cut has been made, and at least one.
    pub fn is_done(&self) -> bool {
        self.cut.is_none() && self.cuts.is_empty() && !self.held.is_empty()
    }

    /// The value that is being saved: after the peaceful saves always the last.
    fn value(&self) -> u32 {
        let at = self.peaceful.min(self.values.len() - 1);
        self.values[at]
    }

    fn save(&mut self, view: &mut View<'_>) {
        let now_ns = view.now_ns();
        send(view, Frame::command(0, order::SAVE));
        if let Some(cut) = self.cut {
            let fault = Fault::FlashCut {
                operation: cut.operation,
                permille: cut.permille,
            };
            view.plan(at(now_ns, fault));
        }
        self.step = Step::Saving(now_ns);
    }

    /// The answer to the question for the value, asked again and again.
    fn answer(&mut self, view: &mut View<'_>) -> Option<u32> {
        let now_ns = view.now_ns();
        let mut value = None;
        for (_, frame) in view.port(0)?.take_heard() {
            let [operation, number, _, _, a, b, c, d] = frame.data;
            if frame.id.value() == 0x381 && number == self.number && operation == 0 {
                value = Some(u32::from_le_bytes([a, b, c, d]));
            }
        }
        if value.is_none() && now_ns >= self.asked_ns + PAUSE_NS {
            self.asked_ns = now_ns;
            send(view, Frame::read(self.number));
        }
        value
    }

    /// A save is over and the board has told what it holds: on to the next, if there is one.
    fn next(&mut self, value: u32, view: &mut View<'_>) -> Flow {
        match self.cut.take() {
            Some(cut) => self.held.push((cut, value)),
            None => self.saved_in_peace(value, view),
        }
        if self.peaceful == self.values.len() {
            let Some(cut) = self.cuts.pop_front() else {
                return Flow::End;
            };
            self.cut = Some(cut);
            put(&self.before, view);
        }
        let now_ns = view.now_ns();
        view.plan(Planned {
            for_ns: Some(DARK_NS),
            ..at(now_ns, Fault::PowerLoss)
        });
        self.step = Step::Starting(now_ns + DARK_NS);
        Flow::On
    }

    fn saved_in_peace(&mut self, value: u32, view: &mut View<'_>) {
        assert_eq!(value, self.value(), "a save in peace");
        self.peaceful += 1;
        let operations = view.flash().take_log();
        if self.peaceful == self.values.len() {
            self.cuts = (self.choose)(&operations).into();
        } else {
            self.before = pages(view);
        }
    }
}

impl Script for Cuts {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        let now_ns = view.now_ns();
        if self.before.is_empty() {
            self.before = pages(view);
        }
        match self.step {
            Step::Starting(from_ns) if now_ns >= from_ns + STARTED_NS => {
                self.resets = view.resets();
                send(view, Frame::write(self.number, self.value()));
                self.step = Step::Writing(now_ns);
            }
            Step::Writing(from_ns) if now_ns >= from_ns + PAUSE_NS => self.save(view),
            Step::Saving(_) if view.resets() > self.resets => {
                self.step = Step::Asking(now_ns + STARTED_NS);
            }
            Step::Saving(from_ns) if now_ns >= from_ns + SAVED_NS => {
                assert_eq!(self.cut, None, "the save never came so far");
                self.step = Step::Asking(now_ns);
            }
            Step::Asking(from_ns) if now_ns >= from_ns => {
                if let Some(value) = self.answer(view) {
                    return self.next(value, view);
                }
            }
            _ => {}
        }
        Flow::On
    }
}

fn at(ns: u64, fault: Fault) -> Planned {
    Planned {
        trigger: Trigger::At { ns },
        for_ns: None,
        fault,
    }
}

fn send(view: &mut View<'_>, frame: Frame) {
    let now_ns = view.now_ns();
    if let Some(port) = view.port(0) {
        port.send(now_ns, frame.on_the_wire());
    }
}

/// Addresses of the words of both pages: sectors 12 and 13, the first of bank 2.
fn addresses() -> impl Iterator<Item = u64> {
    [12, 13].into_iter().flat_map(|number| {
        let sector = Sector::of_number(number).expect("the chip has 24 sectors");
        (sector.base..sector.base + sector.size).step_by(4)
    })
}

fn pages(view: &mut View<'_>) -> Pages {
    let words = addresses().map(|address| view.word(address));
    words.map(|word| word.expect("flash is there")).collect()
}

fn put(pages: &Pages, view: &mut View<'_>) {
    for (address, &word) in addresses().zip(pages) {
        if view.word(address) != Some(word) {
            assert!(view.program_word(address, word), "{address:#x} is flash");
        }
    }
}
