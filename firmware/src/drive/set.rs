//! What 1010h stores, as one set of words in the flash.

use core::task::Poll;

use canopen::dictionary::{Access, Address, Entry};
use canopen::{Abort, ParameterGroup};

use super::kept::{self, Kept};
use crate::{
    dictionary::DICTIONARY,
    parameters::{BoardParameters, WORDS},
    store::{EDGES, Loaded, Origin, Stored},
};

/// Whether the server keeps this object, and it is a parameter.
const fn is_communication(index: u16) -> bool {
    matches!(index, 0x1000..0x2000) && !matches!(index, 0x1003 | 0x1010 | 0x1011)
}

/// Stands for no place.
const NOWHERE: u8 = u8::MAX;

/// Entries of the dictionary.
const ENTRIES: usize = DICTIONARY.entries().len();

/// How many communication parameters there are, and for each entry of the dictionary its place among them.
const PLACES: (usize, [u8; ENTRIES]) = {
    let rows = DICTIONARY.entries();
    let mut places = [NOWHERE; ENTRIES];
    let (mut count, mut at) = (0, 0);
    while at < rows.len() {
        let row = &rows[at];
        if matches!(row.access(), Access::ReadWrite) && is_communication(row.address().index) {
            places[at] = count as u8;
            count += 1;
        }
        at += 1;
    }
    assert!(count < NOWHERE as usize, "a place is a byte");
    (count, places)
};

/// Communication parameters.
const COMMUNICATION: usize = PLACES.0;

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

    /// What was loaded from the flash, or that.
    pub fn loaded(loaded: &Loaded<Self>) -> Self {
        if loaded.origin == Origin::Stored {
            loaded.parameters
        } else {
            Self::defaults()
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

/// For each entry of the dictionary its place.
static PLACE_OF: [u8; ENTRIES] = PLACES.1;

/// Where a communication parameter is stored.
fn place(address: Address) -> Option<usize> {
    let at = DICTIONARY.position(address)?;
    let place = PLACE_OF.get(at).copied()?;
    (place != NOWHERE).then_some(usize::from(place))
}

/// All communication parameters, in the order of the dictionary and of their places.
pub(super) fn communication_parameters() -> impl Iterator<Item = &'static Entry> {
    let rows = DICTIONARY.entries().iter().zip(&PLACE_OF);
    let stored = rows.filter(|(_, place)| **place != NOWHERE);
    stored.map(|(row, _)| row)
}

/// Who wants something to be stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Asker {
    /// 1010h.
    Save(ParameterGroup),
    /// 1011h.
    Restore(ParameterGroup),
    /// Layer setting services.
    Lss,
}

/// How far a save is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Idle,
    /// The flash is to be written.
    Wanted(Asker),
    /// It is being written.
    Running(Asker),
    /// The flash is done, and who asked does not know yet.
    Over(Asker, bool),
}

/// What the flash holds, and what it shall hold.
#[derive(Debug)]
pub(super) struct Store {
    set: Set,
    /// Taken for the set once the flash has it.
    candidate: Set,
    phase: Phase,
    /// Who asked is gone.
    is_abandoned: bool,
}

impl Store {
    pub fn new(set: Set) -> Self {
        Self {
            set,
            candidate: set,
            phase: Phase::Idle,
            is_abandoned: false,
        }
    }

    /// What the flash holds.
    pub fn set(&self) -> &Set {
        &self.set
    }

    /// The stored value of a communication parameter.
    pub fn communication(&self, address: Address) -> Option<u32> {
        let stored = self
            .set
            .has_communication
            .then_some(&self.set.communication)?;
        let word = stored.get(place(address)?).copied()?;
        let follows = || DICTIONARY.find(address).is_ok_and(Entry::has_node_id);
        (word != BY_NODE_ID || !follows()).then_some(word)
    }

    /// Whether this one has asked and does not know the end yet.
    pub fn has_asked(&self, asker: Asker) -> bool {
        matches!(self.phase, Phase::Wanted(owner) | Phase::Running(owner) | Phase::Over(owner, _) if owner == asker)
    }

    /// For the flash, once.
    pub fn take(&mut self) -> Option<&Set> {
        let Phase::Wanted(asker) = self.phase else {
            return None;
        };
        self.phase = Phase::Running(asker);
        Some(&self.candidate)
    }

    /// The flash is done.
    pub fn finish(&mut self, done: bool) {
        let Phase::Running(asker) = self.phase else {
            return;
        };
        if done {
            self.set = self.candidate;
        }
        self.phase = if self.is_abandoned {
            Phase::Idle
        } else {
            Phase::Over(asker, done)
        };
        self.is_abandoned = false;
    }

    /// Whoever asked over SDO does not wait any more; what the flash has begun it ends.
    pub fn abandon(&mut self) {
        match self.phase {
            Phase::Idle | Phase::Wanted(Asker::Lss) | Phase::Running(Asker::Lss) => {}
            Phase::Over(Asker::Lss, _) => {}
            Phase::Over(..) => self.phase = Phase::Idle,
            Phase::Wanted(_) | Phase::Running(_) => self.is_abandoned = true,
        }
    }

    /// Changes the set and waits until the flash holds it. It is called again and again until it is ready, with the same
    /// change; whoever comes while another one's is written waits for its end.
    pub fn save(&mut self, asker: Asker, change: impl FnOnce(&mut Set)) -> Poll<Result<(), Abort>> {
        match self.phase {
            Phase::Idle => {
                self.candidate = self.set;
                change(&mut self.candidate);
                self.phase = Phase::Wanted(asker);
                Poll::Pending
            }
            Phase::Over(owner, done) if owner == asker => {
                self.phase = Phase::Idle;
                Poll::Ready(done.then_some(()).ok_or(Abort::Hardware))
            }
            _ => Poll::Pending,
        }
    }
}

/// What stands for a COB-ID that follows the node-ID as the dictionary has it; no COB-ID is all ones.
const BY_NODE_ID: u32 = u32::MAX;

/// Takes over what is in force.
pub(super) fn keep(
    set: &mut Set,
    group: ParameterGroup,
    (board, kept, node_id): (&BoardParameters, &Kept, u8),
    communication: &mut dyn Iterator<Item = (Address, u32)>,
) {
    if group.has_communication() {
        // Those come in the order of the dictionary, too: nobody has to look for a hundred places.
        let mut places = communication_parameters().zip(&mut set.communication);
        for (address, value) in communication {
            let Some((row, word)) = places.find(|(row, _)| row.address() == address) else {
                break;
            };
            let is_default = row.has_node_id() && row.default_value(node_id) == value;
            *word = if is_default { BY_NODE_ID } else { value };
        }
        set.has_communication = true;
    }
    if has_application(group) {
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
        set.board = BoardParameters {
            bus: set.board.bus,
            ..BoardParameters::DEFAULT
        };
        set.kept = *Kept::defaults().words();
    }
}

fn has_application(group: ParameterGroup) -> bool {
    matches!(group, ParameterGroup::All | ParameterGroup::Application)
}
