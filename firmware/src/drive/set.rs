//! What 1010h stores, as one set of words in the flash.

use core::task::Poll;

use canopen::dictionary::{Access, Address};
use canopen::{Abort, ParameterGroup};

use super::kept::{self, Kept};
use crate::{
    dictionary::DICTIONARY,
    parameters::{BoardParameters, WORDS},
    store::{EDGES, Stored},
};

/// Whether the server keeps this object, and it is a parameter.
const fn is_communication(index: u16) -> bool {
    matches!(index, 0x1000..0x2000) && !matches!(index, 0x1003 | 0x1010 | 0x1011)
}

/// Communication parameters.
const COMMUNICATION: usize = {
    let entries = DICTIONARY.entries();
    let (mut count, mut at) = (0, 0);
    while at < entries.len() {
        let entry = &entries[at];
        let writable = matches!(entry.access(), Access::ReadWrite);
        count += (writable && is_communication(entry.address().index)) as usize;
        at += 1;
    }
    count
};

/// Words of a set: the board's parameters, what the drive keeps, the communication parameters, and which of these are there.
const SET: usize = WORDS + kept::COUNT + COMMUNICATION + 1;

/// Everything that is stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Set {
    /// The parameters of the board, node-ID and bit rate among them.
    pub board: BoardParameters,
    kept: [u32; kept::COUNT],
    communication: [u32; COMMUNICATION],
    /// The communication parameters are stored; else those of the dictionary serve.
    has_communication: bool,
}

impl Set {
    /// As it leaves the factory.
    pub fn defaults() -> Self {
        Self {
            kept: *Kept::defaults().words(),
            ..<Self as Stored>::DEFAULT
        }
    }

    pub(super) fn kept(&self) -> Kept {
        Kept::of(&self.kept)
    }
}

impl Stored for Set {
    /// "SC", and the version of the layout: one more with each change of the dictionary.
    const MAGIC: u32 = 0x5343_0001;
    /// Without the values of the dictionary: [`Set::defaults`] has them.
    const DEFAULT: Self = Self {
        board: BoardParameters::DEFAULT,
        kept: [0; kept::COUNT],
        communication: [0; COMMUNICATION],
        has_communication: false,
    };
    type Page = [u32; SET + EDGES];
    const ZEROS: Self::Page = [0; SET + EDGES];

    fn write(&self, words: &mut [u32]) {
        let content = self.board.words().into_iter();
        let content = content.chain(self.kept).chain(self.communication);
        let content = content.chain([u32::from(self.has_communication)]);
        for (word, content) in words.iter_mut().zip(content) {
            *word = content;
        }
    }

    fn read(words: &[u32]) -> Option<Self> {
        let (board, rest) = words.split_first_chunk()?;
        let (kept, rest) = rest.split_first_chunk()?;
        let (communication, rest) = rest.split_first_chunk()?;
        Some(Self {
            board: BoardParameters::from_words(board)?,
            kept: *kept,
            communication: *communication,
            has_communication: rest.first() == Some(&1),
        })
    }
}

/// Where a communication parameter is stored.
fn place(address: Address) -> Option<usize> {
    let entries = DICTIONARY.entries().iter();
    entries
        .filter(|entry| entry.access() == Access::ReadWrite)
        .map(|entry| entry.address())
        .filter(|address| is_communication(address.index))
        .position(|other| other == address)
}

/// How far a save is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Idle,
    /// The flash is to be written.
    Wanted,
    /// It is being written.
    Running,
    Over(bool),
}

/// What the flash holds, or shall hold.
#[derive(Debug)]
pub(super) struct Store {
    set: Set,
    phase: Phase,
}

impl Store {
    pub fn new(set: Set) -> Self {
        Self {
            set,
            phase: Phase::Idle,
        }
    }

    /// The set.
    pub fn set(&self) -> &Set {
        &self.set
    }

    /// The stored value of a communication parameter.
    pub fn communication(&self, address: Address) -> Option<u32> {
        let stored = self
            .set
            .has_communication
            .then_some(&self.set.communication)?;
        stored.get(place(address)?).copied()
    }

    /// For the flash, once.
    pub fn take(&mut self) -> Option<Set> {
        (self.phase == Phase::Wanted).then(|| {
            self.phase = Phase::Running;
            self.set
        })
    }

    /// The flash is done.
    pub fn finish(&mut self, done: bool) {
        if self.phase == Phase::Running {
            self.phase = Phase::Over(done);
        }
    }

    /// Changes the set and waits until the flash holds it. It is called again and again until it is ready, with the same
    /// change.
    pub fn save(&mut self, change: impl FnOnce(&mut Set)) -> Poll<Result<(), Abort>> {
        match self.phase {
            Phase::Idle => {
                change(&mut self.set);
                self.phase = Phase::Wanted;
                Poll::Pending
            }
            Phase::Wanted | Phase::Running => Poll::Pending,
            Phase::Over(done) => {
                self.phase = Phase::Idle;
                Poll::Ready(done.then_some(()).ok_or(Abort::Hardware))
            }
        }
    }
}

/// Takes over what is in force.
pub(super) fn keep(
    set: &mut Set,
    group: ParameterGroup,
    (board, kept): (&BoardParameters, &Kept),
    communication: &mut dyn Iterator<Item = (Address, u32)>,
) {
    if group.has_communication() {
        for (address, value) in communication {
            let word = place(address).and_then(|at| set.communication.get_mut(at));
            if let Some(word) = word {
                *word = value;
            }
        }
        set.has_communication = true;
    }
    if has_application(group) {
        // Node-ID and bit rate are LSS' to store, and the node's in force is not touched.
        set.board = *board;
        set.kept = *kept.words();
    }
}

/// Goes back to the defaults; node-ID and bit rate stay, or a client would lose the device.
pub(super) fn forget(set: &mut Set, group: ParameterGroup) {
    if group.has_communication() {
        set.has_communication = false;
    }
    if has_application(group) {
        let defaults = Set::defaults();
        let bus = set.board.bus;
        set.board = defaults.board;
        set.board.bus = bus;
        set.kept = defaults.kept;
    }
}

fn has_application(group: ParameterGroup) -> bool {
    matches!(group, ParameterGroup::All | ParameterGroup::Application)
}
