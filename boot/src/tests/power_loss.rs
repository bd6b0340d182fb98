//! The supply is cut in every operation of a whole update, and in every operation of the recovery
//! from each of these cuts.

use std::{format, println, string::String};

use rand_pcg::{Pcg32, rand_core::Rng};

use super::{
    life::{NewProgram, Update},
    model::{Model, Progress},
};
use crate::install::{PLANTED, Planted};

/// States that a published test of a bootloader claims; this one shall have more.
const PUBLISHED: u64 = 12_109;

/// How an operation is cut: at its beginning, which is the end of the one before, in the middle,
/// and just before its end.
const FIRST_CUTS: [Progress; 3] = [Progress::None, Progress::Partial(1), Progress::Nearly(2)];

/// Of the second cut.
const SECOND_CUT: Progress = Progress::Partial(3);

/// Runs an update to its end after the cuts that were made; an error names the last of them.
fn finish(update: &Update, mut flash: Model) -> Result<(), String> {
    let has_ended = update.run(&mut flash)?;
    assert!(has_ended, "no further cut was planned");
    update.check_end(&flash)
}

/// Every single cut, and every second cut after each; returns the number of states.
fn cut_everywhere(program: NewProgram) -> Result<u64, String> {
    let update = Update::new(program);
    let mut states = 0;
    for first in 0.. {
        let mut is_behind = false;
        for progress in FIRST_CUTS {
            let mut flash = update.board();
            flash.cut_after(first, progress);
            update.run(&mut flash)?;
            is_behind = flash.awaits_cut();
            if is_behind {
                break;
            }
            states += cut_again(&update, &flash).map_err(|(second, error)| {
                format!("{program:?}, cut in {first} ({progress:?}), {second}: {error}")
            })?;
        }
        if is_behind {
            return Ok(states);
        }
    }
    Ok(states)
}

/// The recovery from a cut, and every cut of it; returns the number of states.
fn cut_again(update: &Update, after: &Model) -> Result<u64, (String, String)> {
    finish(update, after.clone()).map_err(|error| ("no second cut".into(), error))?;
    let mut states = 1;
    for second in 0.. {
        let with_cut = |error| (format!("then in {second} ({SECOND_CUT:?})"), error);
        let mut flash = after.clone();
        flash.cut_after(second, SECOND_CUT);
        update.run(&mut flash).map_err(with_cut)?;
        if flash.awaits_cut() {
            return Ok(states);
        }
        finish(update, flash).map_err(with_cut)?;
        states += 1;
    }
    Ok(states)
}

#[test]
fn an_update_survives_every_cut_and_every_second_cut_during_the_recovery() {
    let mut all = 0;
    for program in [NewProgram::Works, NewProgram::Fails] {
        let states = cut_everywhere(program).unwrap_or_else(|error| panic!("{error}"));
        println!("new program {program:?}: {states} states");
        all += states;
    }
    assert!(all > PUBLISHED, "{all}");
}

#[test]
fn an_update_survives_any_number_of_cuts_at_random_places() {
    let mut cuts = 0_u64;
    let updates = [NewProgram::Works, NewProgram::Fails].map(Update::new);
    for (seed, update) in (0..2_000).zip(updates.iter().cycle()) {
        let mut random = Pcg32::new(seed, 5);
        let mut flash = update.board();
        let left = 1 + random.next_u32() % 12;
        // A trial that is cut off often enough is rolled back: that is judged as well.
        for _ in 0..left {
            let seed = random.next_u32().into();
            let progress = [Progress::Partial(seed), Progress::Nearly(seed)][seed as usize % 2];
            flash.cut_after((random.next_u32() % 300).into(), progress);
            match update.run(&mut flash) {
                Ok(_) => cuts += 1,
                Err(error) if error.contains("rolled back") => break,
                Err(error) => panic!("seed {seed}: {error}"),
            }
        }
    }
    println!("{cuts} cuts");
}

/// Whether the test finds a planted defect.
fn is_found(planted: Planted) -> bool {
    PLANTED.set(Some(planted));
    let mut programs = [NewProgram::Fails, NewProgram::Works].into_iter();
    let found = programs.find_map(|program| cut_everywhere(program).err());
    PLANTED.set(None);
    println!("{planted:?}: {found:?}");
    found.is_some()
}

#[test]
fn records_in_the_wrong_order_are_found() {
    assert!(is_found(Planted::InstallBeforeBackup));
    assert!(is_found(Planted::TrialBeforeCopy));
}

#[test]
fn a_decision_by_a_record_that_was_cut_off_is_found() {
    assert!(is_found(Planted::StaleRecord));
}
