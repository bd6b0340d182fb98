//! A flash that loses its power at any of its operations.

extern crate std;

use proptest::prelude::*;
use std::{vec, vec::Vec};

use super::*;

const FIELDS: usize = 53;

/// Words of a page of the set.
const PAGE_WORDS: usize = FIELDS + EDGES;

const fn field(name: &'static str) -> Field {
    Field {
        name,
        address: 0,
        data_type: "i32",
    }
}

/// A set of words, the first of which is a node-ID; `LAYOUT` is the hash of its layout.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Set<const LAYOUT: u32, const SIZE: usize = FIELDS>([u32; SIZE]);

impl<const LAYOUT: u32, const SIZE: usize> Set<LAYOUT, SIZE> {
    const fn with_node_id(node_id: u32) -> Self {
        let mut words = [7; SIZE];
        words[0] = node_id;
        Self(words)
    }
}

macro_rules! stored {
    ($($size:literal)+) => {
        $(impl<const LAYOUT: u32> Stored for Set<LAYOUT, $size> {
            const LAYOUT: u32 = LAYOUT;
            const DEFAULT: Self = Self::with_node_id(1);
            type Page = [u32; $size + EDGES];
            const ZEROS: Self::Page = [0; $size + EDGES];

            fn write(&self, words: &mut [u32]) {
                words.copy_from_slice(&self.0);
            }

            fn read(words: &[u32]) -> Option<Self> {
                let words: [u32; $size] = words.try_into().ok()?;
                (1..128).contains(&words[0]).then_some(Self(words))
            }
        })+
    };
}

stored!(52 53 54);

const LAYOUT: u32 = layout_hash(&[field("node_id"), field("current_ma")]);

type TestSet = Set<LAYOUT>;

fn load<const ROW: usize>(flash: &FakeFlash<ROW>) -> Loaded<TestSet> {
    super::load(flash)
}

/// More words than a set needs: their content must not matter.
const WORDS: usize = PAGE_WORDS + 8;

/// Polls for which an erase is busy.
const ERASE_POLLS: usize = 5;

/// A flash whose bits only fall until they are erased, and which writes rows of `ROW` words.
#[derive(Debug, Clone)]
struct FakeFlash<const ROW: usize = 1> {
    pages: [Vec<u32>; 2],
    busy: usize,
    fails: bool,
    /// Stages until the power is lost; each word and each erase has several.
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

impl<const ROW: usize> FakeFlash<ROW> {
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

    /// The last stage that an operation reaches before the power is lost.
    fn stages(&mut self) -> Stage {
        let stages = [Stage::Before, Stage::Half, Stage::Done];
        let left = self.power.unwrap_or(usize::MAX);
        self.power = self.power.map(|power| power.saturating_sub(2));
        stages[left.min(2)]
    }

    /// Pseudo-random bits.
    fn noise(&mut self) -> u32 {
        self.seed = self
            .seed
            .wrapping_mul(1_664_525)
            .wrapping_add(1_013_904_223);
        self.seed.rotate_left(13) ^ self.seed
    }

    /// The same memory after a power-up.
    fn powered_again(&self, power: Option<usize>) -> Self {
        Self {
            power,
            busy: 0,
            ..self.clone()
        }
    }
}

impl<const ROW: usize> Flash for FakeFlash<ROW> {
    const ROW: usize = ROW;
    const PAGE_BYTES: u32 = 4 * WORDS as u32;

    fn start_erase(&mut self, page: Page) {
        assert_eq!(self.busy, 0, "busy");
        let stage = self.stages();
        for index in 0..WORDS {
            let noise = self.noise();
            let word = &mut self.pages[page as usize][index];
            match stage {
                Stage::Before => {}
                // Some cells are erased, some are not.
                Stage::Half => *word |= noise,
                Stage::Done => *word = u32::MAX,
            }
        }
        self.busy = ERASE_POLLS;
    }

    fn start_program(&mut self, page: Page, offset: u16, row: &[u32]) {
        assert_eq!(self.busy, 0, "busy");
        assert_eq!(usize::from(offset) % (4 * ROW), 0);
        assert_eq!(row.len(), ROW);
        let stage = self.stages();
        for (index, word) in (usize::from(offset / 4)..).zip(row) {
            let noise = self.noise();
            let cell = &mut self.pages[page as usize][index];
            if self.power.is_none() {
                assert_eq!(*cell, u32::MAX, "written twice without an erase");
            }
            match stage {
                Stage::Before => {}
                Stage::Half => *cell &= word | noise,
                Stage::Done => *cell &= word,
            }
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

fn set(node_id: u32) -> TestSet {
    Set::with_node_id(node_id)
}

/// Saves until the save is complete or the power is lost.
fn save<const ROW: usize>(flash: &mut FakeFlash<ROW>, parameters: &TestSet) -> Progress {
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

/// A used flash: both pages hold sets, the newest one has node-ID 2.
fn used<const ROW: usize>() -> FakeFlash<ROW> {
    let mut flash = FakeFlash::new();
    assert_eq!(save(&mut flash, &set(1)), Progress::Done);
    assert_eq!(save(&mut flash, &set(2)), Progress::Done);
    flash
}

/// Stages of a complete save with rows of this length.
const fn stages(row: usize) -> usize {
    2 * (1 + PAGE_WORDS.div_ceil(row))
}

#[test]
fn an_empty_flash_gives_the_defaults_and_a_saved_one_what_was_saved() {
    let mut flash = FakeFlash::<1>::new();
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
    lose_power_at_any_operation::<1>();
    lose_power_at_any_operation::<2>();
    lose_power_at_any_operation::<8>();
}

fn lose_power_at_any_operation<const ROW: usize>() {
    let mut ends = [0; 2];
    for seed in 0..20 {
        for power in 0..=stages(ROW) {
            let mut flash = used::<ROW>().powered_again(Some(power));
            flash.seed = seed;
            save(&mut flash, &set(3));
            let flash = flash.powered_again(None);
            let loaded = load(&flash);
            assert_eq!(loaded.origin, Origin::Stored, "stage {power}");
            let is_new = loaded.parameters == set(3);
            assert!(is_new || loaded.parameters == set(2), "stage {power}");
            ends[usize::from(is_new)] += 1;
            // The next save succeeds for any remaining contents.
            let mut flash = flash;
            assert_eq!(save(&mut flash, &set(4)), Progress::Done, "stage {power}");
            assert_eq!(load(&flash).parameters, set(4));
        }
    }
    assert!(ends[0] > 0 && ends[1] > 0, "{ends:?}");
}

#[test]
fn a_second_loss_during_the_recovery_leaves_a_valid_set_as_well() {
    for first in 0..=stages(1) {
        for second in 0..=stages(1) {
            let mut flash = used::<1>().powered_again(Some(first));
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
    for power in 0..=stages(1) {
        let mut flash = FakeFlash::<1>::new().powered_again(Some(power));
        save(&mut flash, &set(3));
        let loaded = load(&flash.powered_again(None));
        match loaded.origin {
            Origin::Stored => assert_eq!(loaded.parameters, set(3)),
            Origin::Defaults => assert_eq!(loaded.parameters, TestSet::DEFAULT),
            // A half-written CRC cannot be distinguished from a corrupt page: it is reported as
            // such, and the defaults are used.
            Origin::DefaultsInsteadOfCorrupt => {
                // The page is blank: there is no erase.
                assert_eq!(power, stages(1) - 3);
                assert_eq!(loaded.parameters, TestSet::DEFAULT);
            }
        }
    }
}

#[test]
fn a_single_corrupt_set_is_reported() {
    let mut flash = FakeFlash::<1>::new();
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
fn a_failing_flash_is_reported_and_the_old_set_stays() {
    let mut flash = used::<1>();
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
fn two_corrupt_pages_are_distinguished_from_an_empty_flash() {
    let mut flash = used::<1>();
    for page in &mut flash.pages {
        page[7] ^= 1;
    }
    let loaded = load(&flash);
    assert_eq!(loaded.origin, Origin::DefaultsInsteadOfCorrupt);
    assert_eq!(loaded.parameters, TestSet::DEFAULT);
}

/// Loads a page that was saved with another layout.
fn origin_after_save_as<S: Stored>(other: &S) -> Origin {
    let mut flash = FakeFlash::<1>::new();
    let page = first_page(other);
    flash.pages[0][..page.as_ref().len()].copy_from_slice(page.as_ref());
    assert_eq!(super::load::<S>(&flash).origin, Origin::Stored);
    let loaded = load(&flash);
    assert_eq!(loaded.parameters, TestSet::DEFAULT);
    loaded.origin
}

/// Each of the other sets is valid in its own layout, CRC and values included.
#[test]
fn a_page_of_another_layout_is_refused_as_corrupt() {
    const REORDERED: u32 = layout_hash(&[field("current_ma"), field("node_id")]);
    const RENAMED: u32 = layout_hash(&[field("node_id"), field("voltage_mv")]);
    const OTHER_TYPE: u32 = layout_hash(&[
        field("node_id"),
        Field {
            data_type: "f32",
            ..field("current_ma")
        },
    ]);
    const LONGER: u32 = layout_hash(&[field("node_id"), field("current_ma"), field("mode")]);
    const SHORTER: u32 = layout_hash(&[field("node_id")]);
    let origins = [
        origin_after_save_as(&Set::<REORDERED, 53>::with_node_id(5)),
        origin_after_save_as(&Set::<RENAMED, 53>::with_node_id(5)),
        origin_after_save_as(&Set::<OTHER_TYPE, 53>::with_node_id(5)),
        origin_after_save_as(&Set::<LONGER, 54>::with_node_id(5)),
        origin_after_save_as(&Set::<SHORTER, 52>::with_node_id(5)),
    ];
    assert_eq!(origins, [Origin::DefaultsInsteadOfCorrupt; 5]);
}

proptest! {
    #[test]
    fn a_flipped_bit_is_detected_and_the_other_page_is_used(index in 0..PAGE_WORDS, bit in 0..32) {
        let mut flash = used::<1>();
        // The second save went to the second page.
        flash.pages[1][index] ^= 1_u32 << bit;
        prop_assert_eq!(load(&flash).parameters, set(1));
    }

    #[test]
    fn any_content_can_be_read(words in proptest::collection::vec(any::<u32>(), WORDS)) {
        let mut flash = used::<1>();
        flash.pages[1] = words;
        prop_assert_eq!(load(&flash).parameters, set(1));
    }
}
