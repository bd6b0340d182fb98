//! A flash that loses its power at any of its operations.

extern crate std;

use proptest::prelude::*;
use std::{vec, vec::Vec};

use super::{page::PAGE_WORDS, *};

/// More words than a set needs: what lies behind must not matter.
const WORDS: usize = PAGE_WORDS + 8;

/// Polls for which an erase is busy.
const ERASE_POLLS: usize = 5;

/// A flash whose bits only fall until they are erased.
#[derive(Debug, Clone)]
struct FakeFlash {
    pages: [Vec<u32>; 2],
    busy: usize,
    fails: bool,
    /// Stages until the power is lost; each word and each erase has some.
    power: Option<usize>,
    seed: u32,
}

/// What a stage of an operation leaves.
#[derive(Clone, Copy)]
enum Stage {
    Before,
    Half,
    Done,
}

impl FakeFlash {
    fn new() -> Self {
        Self {
            pages: [vec![u32::MAX; WORDS], vec![u32::MAX; WORDS]],
            busy: 0,
            fails: false,
            power: None,
            seed: 1,
        }
    }

    fn is_powered(&self) -> bool {
        self.power != Some(0)
    }

    /// The power lasts for one stage less; the last stage that it reaches.
    fn stages(&mut self) -> Stage {
        let stages = [Stage::Before, Stage::Half, Stage::Done];
        let left = self.power.unwrap_or(usize::MAX);
        self.power = self.power.map(|power| power.saturating_sub(2));
        stages[left.min(2)]
    }

    /// Bits of no pattern.
    fn noise(&mut self) -> u32 {
        self.seed = self
            .seed
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        self.seed.rotate_left(13) ^ self.seed
    }

    /// The same memory behind a new power-up.
    fn powered_again(&self, power: Option<usize>) -> Self {
        Self {
            power,
            busy: 0,
            ..self.clone()
        }
    }
}

impl Flash for FakeFlash {
    fn start_erase(&mut self, page: Page) {
        assert_eq!(self.busy, 0, "busy");
        let stage = self.stages();
        for index in 0..WORDS {
            let noise = self.noise();
            let word = &mut self.pages[page as usize][index];
            match stage {
                Stage::Before => {}
                // Some cells have let go, some have not.
                Stage::Half => *word |= noise,
                Stage::Done => *word = u32::MAX,
            }
        }
        self.busy = ERASE_POLLS;
    }

    fn start_program(&mut self, page: Page, offset: u16, word: u32) {
        assert_eq!(self.busy, 0, "busy");
        assert_eq!(offset % 4, 0);
        let stage = self.stages();
        let noise = self.noise();
        let cell = &mut self.pages[page as usize][usize::from(offset / 4)];
        if self.power.is_none() {
            assert_eq!(*cell, u32::MAX, "written twice without an erase");
        }
        match stage {
            Stage::Before => {}
            Stage::Half => *cell &= word | noise,
            Stage::Done => *cell &= word,
        }
        self.busy = 1;
    }

    fn status(&mut self) -> Status {
        if self.busy > 0 {
            self.busy -= 1;
            return Status::Busy;
        }
        if self.fails {
            Status::Failed
        } else {
            Status::Ready
        }
    }

    fn read(&self, page: Page, offset: u16) -> u32 {
        assert_eq!(self.busy, 0, "busy");
        self.pages[page as usize][usize::from(offset / 4)]
    }
}

fn set(node_id: i32) -> BoardParameters {
    let mut parameters = BoardParameters::DEFAULT;
    parameters.bus.node_id = node_id;
    assert!(parameters.control.set(0, node_id as f32));
    parameters
}

/// Saves until it is done or the power is gone.
fn save(flash: &mut FakeFlash, parameters: &BoardParameters) -> Progress {
    let mut saver = Saver::new(&load(flash));
    assert!(saver.start(parameters));
    while flash.is_powered() {
        match saver.poll(flash) {
            Progress::Running => {}
            end => return end,
        }
    }
    Progress::Running
}

/// A flash that was used: both pages hold sets, the newest one node 2.
fn used() -> FakeFlash {
    let mut flash = FakeFlash::new();
    assert_eq!(save(&mut flash, &set(1)), Progress::Done);
    assert_eq!(save(&mut flash, &set(2)), Progress::Done);
    flash
}

/// Stages of a whole save.
const STAGES: usize = 2 * (1 + PAGE_WORDS);

#[test]
fn an_empty_flash_gives_the_defaults_and_a_saved_one_what_was_saved() {
    let mut flash = FakeFlash::new();
    assert_eq!(load(&flash).origin, Origin::Defaults);
    for node_id in 1..100 {
        assert_eq!(save(&mut flash, &set(node_id)), Progress::Done);
        let loaded = load(&flash);
        assert_eq!(loaded.origin, Origin::Stored);
        assert_eq!(loaded.parameters, set(node_id));
    }
}

#[test]
fn a_loss_of_power_at_any_operation_leaves_the_old_or_the_new_set() {
    let mut ends = [0; 2];
    for seed in 0..20 {
        for power in 0..=STAGES {
            let mut flash = used().powered_again(Some(power));
            flash.seed = seed;
            save(&mut flash, &set(3));
            let flash = flash.powered_again(None);
            let loaded = load(&flash);
            assert_eq!(loaded.origin, Origin::Stored, "stage {power}");
            let is_new = loaded.parameters == set(3);
            assert!(is_new || loaded.parameters == set(2), "stage {power}");
            ends[usize::from(is_new)] += 1;
            // The next save works, whatever was left.
            let mut flash = flash;
            assert_eq!(save(&mut flash, &set(4)), Progress::Done, "stage {power}");
            assert_eq!(load(&flash).parameters, set(4));
        }
    }
    assert!(ends[0] > 0 && ends[1] > 0, "{ends:?}");
}

#[test]
fn a_second_loss_during_the_recovery_leaves_a_valid_set_as_well() {
    for first in 0..=STAGES {
        for second in 0..=STAGES {
            let mut flash = used().powered_again(Some(first));
            save(&mut flash, &set(3));
            let before = load(&flash.powered_again(None)).parameters;
            let mut flash = flash.powered_again(Some(second));
            save(&mut flash, &set(4));
            let loaded = load(&flash.powered_again(None));
            assert_eq!(loaded.origin, Origin::Stored, "{first}, {second}");
            let after = loaded.parameters;
            assert!(after == before || after == set(4), "{first}, {second}");
        }
    }
}

#[test]
fn the_first_save_of_all_leaves_the_defaults_or_the_new_set() {
    for power in 0..=STAGES {
        let mut flash = FakeFlash::new().powered_again(Some(power));
        save(&mut flash, &set(3));
        let loaded = load(&flash.powered_again(None));
        match loaded.origin {
            Origin::Stored => assert_eq!(loaded.parameters, set(3)),
            Origin::Defaults => assert_eq!(loaded.parameters, BoardParameters::DEFAULT),
            // A CRC that stands by half cannot be told from a page that has gone bad: that is told,
            // and the defaults serve.
            Origin::DefaultsInsteadOfCorrupt => {
                // The page is blank: there is no erase.
                assert_eq!(power, STAGES - 3);
                assert_eq!(loaded.parameters, BoardParameters::DEFAULT);
            }
        }
    }
}

#[test]
fn a_single_set_that_has_gone_bad_is_told() {
    let mut flash = FakeFlash::new();
    assert_eq!(save(&mut flash, &set(1)), Progress::Done);
    flash.pages[0][9] ^= 4;
    assert_eq!(load(&flash).origin, Origin::DefaultsInsteadOfCorrupt);
}

#[test]
fn the_newer_set_is_taken_where_the_sequence_number_wraps() {
    assert!(is_newer(0, u32::MAX) && !is_newer(u32::MAX, 0));
    assert!(is_newer(5, 4) && !is_newer(4, 5) && !is_newer(4, 4));
}

#[test]
fn a_flash_that_fails_is_told_and_the_old_set_stays() {
    let mut flash = used();
    flash.fails = true;
    assert_eq!(
        save(&mut flash, &set(3)),
        Progress::Failed(SaveError::Erase)
    );
    flash.fails = false;
    // The other page was erased meanwhile.
    assert_eq!(load(&flash).parameters, set(2));
    let mut saver = Saver::new(&load(&flash));
    assert!(saver.start(&set(3)));
    assert!(!saver.start(&set(4)), "one at a time");
    while saver.step_index() < 3 {
        assert_eq!(saver.poll(&mut flash), Progress::Running);
    }
    flash.fails = true;
    let mut end = saver.poll(&mut flash);
    while end == Progress::Running {
        end = saver.poll(&mut flash);
    }
    assert_eq!(end, Progress::Failed(SaveError::Program));
    assert_eq!(load(&flash).parameters, set(2));
    assert_eq!(saver.poll(&mut flash), Progress::Idle);
}

#[test]
fn both_pages_corrupt_are_told_from_an_empty_flash() {
    let mut flash = used();
    for page in &mut flash.pages {
        page[7] ^= 1;
    }
    let loaded = load(&flash);
    assert_eq!(loaded.origin, Origin::DefaultsInsteadOfCorrupt);
    assert_eq!(loaded.parameters, BoardParameters::DEFAULT);
}

proptest! {
    #[test]
    fn a_flipped_bit_is_seen_and_the_other_page_serves(index in 0..PAGE_WORDS, bit in 0..32) {
        let mut flash = used();
        // The second save went to the second page.
        flash.pages[1][index] ^= 1_u32 << bit;
        prop_assert_eq!(load(&flash).parameters, set(1));
    }

    #[test]
    fn any_content_is_read_without_harm(words in proptest::collection::vec(any::<u32>(), WORDS)) {
        let mut flash = used();
        flash.pages[1] = words;
        prop_assert_eq!(load(&flash).parameters, set(1));
    }
}
