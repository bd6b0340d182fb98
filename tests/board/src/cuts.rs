//! Saves of parameters that are interrupted by a loss of the supply, all in a single run: the
//! emulator translates the program only once.

use std::collections::VecDeque;

use virtual_board::faults::{Fault, Planned, Trigger};
use virtual_board::flash::{Operation, Sector};
use virtual_board::run::{Flow, Script, View};

use crate::frames::{Frame, SAVE, read, to_wire, write};

/// Time from power-on until the board has started and has measured, ns.
const STARTED_NS: u64 = 60_000_000;

/// Time between a new value and the request to save it, and between two read requests, ns.
const PAUSE_NS: u64 = 10_000_000;

/// Upper limit of the duration of a save with the erase of a page, ns.
const SAVED_NS: u64 = 1_500_000_000;

/// Length of the loss of supply between two saves, ns.
const OFF_NS: u64 = 2_000_000;

/// The parameter that is saved: over-current limit, mA.
const PARAMETER: (u16, u8) = (0x2100, 8);

/// Instant of a supply cut: the flash operation of a save, and the elapsed thousandths of its
/// duration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// Number of the operation, counted from the beginning of the save.
    pub operation: u64,
    /// Thousandths.
    pub permille: u64,
}

/// The two pages of parameters, word by word.
type Pages = Vec<u32>;

/// The phase of the sequence, and since when, ns.
#[derive(Debug, Clone, Copy)]
enum Step {
    /// The board starts.
    Starting(u64),
    /// The new value has been written; the request to save it follows.
    Writing(u64),
    /// The board saves.
    Saving(u64),
    /// The board has started after the cut, or completed the save, and its value is read.
    Reading(u64),
}

/// Saves each value without a cut. Then restores the flash to what it was before the last of these
/// saves, saves the last value again and cuts the supply, once for each chosen cut.
pub struct Cuts {
    values: Vec<u32>,
    choose: fn(&[Operation]) -> Vec<Cut>,
    cuts: VecDeque<Cut>,
    cut: Option<Cut>,
    /// Saves completed without a cut.
    completed: usize,
    before: Pages,
    step: Step,
    resets: usize,
    requested_ns: u64,
    /// The value that the board had after each cut.
    pub held: Vec<(Cut, u32)>,
}

impl Cuts {
    /// Saves these values of the over-current limit, mA; `choose` returns the cuts, given the flash
    /// operations of the last of these saves.
    ///
    /// # Panics
    /// If there is no value.
    pub fn new(values: &[u32], choose: fn(&[Operation]) -> Vec<Cut>) -> Self {
        assert!(!values.is_empty());
        Self {
            values: values.to_vec(),
            choose,
            cuts: VecDeque::new(),
            cut: None,
            completed: 0,
            before: Pages::new(),
            step: Step::Starting(0),
            resets: 0,
            requested_ns: 0,
            held: Vec::new(),
        }
    }

    /// Whether every chosen cut has been made, and at least one.
    pub fn is_done(&self) -> bool {
        self.cut.is_none() && self.cuts.is_empty() && !self.held.is_empty()
    }

    /// The value that is being saved: for each cut the last.
    fn value(&self) -> u32 {
        let at = self.completed.min(self.values.len() - 1);
        self.values[at]
    }

    fn save(&mut self, view: &mut View<'_>) {
        let now_ns = view.now_ns();
        send(view, write(0x1010, 1, SAVE, 4));
        if let Some(cut) = self.cut {
            let fault = Fault::FlashCut {
                operation: cut.operation,
                permille: cut.permille,
            };
            view.plan(at(now_ns, fault));
        }
        self.step = Step::Saving(now_ns);
    }

    /// The value that the board has, requested until it responds.
    fn response(&mut self, view: &mut View<'_>) -> Option<u32> {
        let now_ns = view.now_ns();
        let (index, sub) = PARAMETER;
        let [low, high] = index.to_le_bytes();
        let mut value = None;
        for (_, frame) in view.port(0)?.take_received() {
            let [command, object @ .., a, b, c, d] = frame.data;
            if (frame.id.value(), command, object) == (0x581, 0x43, [low, high, sub]) {
                value = Some(u32::from_le_bytes([a, b, c, d]));
            }
        }
        if value.is_none() && now_ns >= self.requested_ns + PAUSE_NS {
            self.requested_ns = now_ns;
            send(view, read(index, sub));
        }
        value
    }

    /// Called when a save has ended and its value has been read: begins the next save, if any.
    fn next(&mut self, value: u32, view: &mut View<'_>) -> Flow {
        match self.cut.take() {
            Some(cut) => self.held.push((cut, value)),
            None => self.complete(value, view),
        }
        if self.completed == self.values.len() {
            let Some(cut) = self.cuts.pop_front() else {
                return Flow::End;
            };
            self.cut = Some(cut);
            restore(&self.before, view);
        }
        let now_ns = view.now_ns();
        view.plan(Planned {
            for_ns: Some(OFF_NS),
            ..at(now_ns, Fault::PowerLoss)
        });
        self.step = Step::Starting(now_ns + OFF_NS);
        Flow::Continue
    }

    fn complete(&mut self, value: u32, view: &mut View<'_>) {
        assert_eq!(value, self.value(), "a save without a cut");
        self.completed += 1;
        let operations = view.flash().map_or_else(Vec::new, |flash| flash.take_log());
        if self.completed == self.values.len() {
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
                let (index, sub) = PARAMETER;
                send(view, write(index, sub, self.value(), 4));
                self.step = Step::Writing(now_ns);
            }
            Step::Writing(from_ns) if now_ns >= from_ns + PAUSE_NS => self.save(view),
            Step::Saving(_) if view.resets() > self.resets => {
                self.step = Step::Reading(now_ns + STARTED_NS);
            }
            Step::Saving(from_ns) if now_ns >= from_ns + SAVED_NS => {
                assert_eq!(self.cut, None, "the save did not reach the operation");
                self.step = Step::Reading(now_ns);
            }
            Step::Reading(from_ns) if now_ns >= from_ns => {
                if let Some(value) = self.response(view) {
                    return self.next(value, view);
                }
            }
            _ => {}
        }
        Flow::Continue
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
        port.send(now_ns, to_wire(&frame));
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

fn restore(pages: &Pages, view: &mut View<'_>) {
    for (address, &word) in addresses().zip(pages) {
        if view.word(address) != Some(word) {
            assert!(view.program_word(address, word), "{address:#x} is flash");
        }
    }
}
