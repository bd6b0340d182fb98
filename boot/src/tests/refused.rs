//! Images that must not be installed.

use std::{
    collections::BTreeMap, println, string::String, string::ToString, sync::LazyLock, vec, vec::Vec,
};

use rand_pcg::{Pcg32, rand_core::Rng};
use salty::Keypair;

use super::{
    images::{HARDWARE, PROGRAM, Remembering, assemble, draft, header, image, key, keys, signed},
    model::{Model, SMALL},
};
use crate::{
    check::Refusal,
    flash::Flash,
    flash::ReadFlash,
    header::{CRC, HEADER_SIZE, Header, Version},
    install::{Bootloader, Cause, Decision},
    log,
    record::{Outcome, State},
    signature::Verifier,
};

/// The version that runs on the board.
const PRESENT: u32 = 5;

/// The image that runs on the board.
static RUNNING: LazyLock<Vec<u8>> = LazyLock::new(|| image(PRESENT));

/// A verifier that accepts everything: a planted defect.
struct Unsigned;

impl Verifier for Unsigned {
    fn verify(&self, _: u32, _: &[u8], _: &[u8; 64]) -> bool {
        true
    }
}

/// Offers an image to a board, whose program checks it or not before it requests the installation;
/// returns the reason of the refusal by each, `None` where it is installed.
fn offer(image: &[u8], verifier: impl Verifier + Copy) -> [Option<String>; 2] {
    [true, false].map(|is_checked| {
        let mut flash = Model::new();
        flash.load(SMALL.slot.start(), &RUNNING);
        let mut board = Bootloader {
            flash: &mut flash,
            layout: &SMALL,
            hardware: HARDWARE,
            verifier,
        };
        assert_eq!(
            board.start(Cause::PowerOn),
            Decision::Run { is_trial: false }
        );
        let length = image.len().min(SMALL.staging.size() as usize);
        board.flash.load(SMALL.staging.start(), &image[..length]);
        if is_checked {
            if let Err(refusal) = board.request() {
                return Some(std::format!("{refusal:?}"));
            }
        } else {
            let identity = Header::read(image).map_or(0, |header| header.identity());
            let state = board.state().request(identity);
            log::append(board.flash, &SMALL.records, &state).expect("the supply is on");
        }
        let before = board
            .flash
            .bytes(SMALL.slot.start(), SMALL.slot.size())
            .to_vec();
        let decision = board.start(Cause::PowerOn);
        if decision == (Decision::Run { is_trial: true }) {
            return None;
        }
        assert_eq!(decision, Decision::Run { is_trial: false });
        assert_eq!(board.state().outcome, Outcome::Refused);
        let slot = board.flash.bytes(SMALL.slot.start(), SMALL.slot.size());
        assert_eq!(slot, before, "the slot was touched");
        Some("Refused".to_string())
    })
}

impl<V: Verifier> Verifier for &V {
    fn verify(&self, key: u32, message: &[u8], signature: &[u8; 64]) -> bool {
        (**self).verify(key, message, signature)
    }
}

/// All variants of an image that must be refused, with their kind.
fn damaged() -> Vec<(&'static str, Vec<u8>)> {
    let good = image(PRESENT + 1);
    let used = header(&good).bytes().len();
    let start = HEADER_SIZE as usize;
    let mut all = Vec::new();
    for bit in (0..8 * used).chain(8 * start..8 * good.len()) {
        let mut flipped = good.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        all.push(("bit flipped", flipped));
    }
    // As an attacker flips it: the CRC of the header is right.
    let crc = used - 4;
    for byte in 8..crc {
        let mut forged = good.clone();
        forged[byte] ^= 1;
        let sum = CRC.checksum(&forged[..crc]);
        forged[crc..used].copy_from_slice(&sum.to_le_bytes());
        all.push(("forged", forged));
    }
    for length in (0..used).chain(start..good.len()) {
        let mut cut = good[..length].to_vec();
        cut.resize(good.len(), 0xff);
        all.push(("truncated", cut));
    }
    // Words, and the seven bytes of a segment.
    for size in [4, 7] {
        let pieces = PROGRAM / size;
        for a in 0..pieces {
            for b in 0..a {
                let mut swapped = good.clone();
                for byte in 0..size {
                    swapped.swap(start + a * size + byte, start + b * size + byte);
                }
                all.push(("reordered", swapped));
            }
        }
    }
    for words in 1..PROGRAM / 4 {
        let mut shifted = good.clone();
        shifted[start..].rotate_left(4 * words);
        all.push(("reordered", shifted));
    }
    let mut random = Pcg32::new(1, 3);
    for _ in 0..50 {
        let mut bytes = vec![0; good.len()];
        random.fill_bytes(&mut bytes);
        all.push(("random", bytes.clone()));
        // With a header that says what the board expects.
        let (mut draft, _) = draft(PRESENT + 1, 1);
        random.fill_bytes(&mut draft.signature);
        all.push((
            "signature of random bytes",
            assemble(&draft, &bytes[start..]),
        ));
    }
    all.extend(misfits());
    all
}

/// Images that are whole and signed, but must not be installed on this board.
fn misfits() -> Vec<(&'static str, Vec<u8>)> {
    let (fits, program) = draft(PRESENT + 1, 9);
    let mut all = Vec::new();
    let mut add = |kind, header: Header, keys: &Keypair| {
        all.push((kind, signed(header, &program, keys)));
    };
    for version in 0..PRESENT {
        let version = Version(version);
        add("downgraded", Header { version, ..fits }, &keys());
        for replaces in (0..2 * PRESENT).filter(|replaces| *replaces != PRESENT) {
            let replaces = Version(replaces);
            let header = Header {
                version,
                replaces,
                ..fits
            };
            add("recovery of another version", header, &keys());
        }
    }
    for bit in 0..32 {
        let hardware = HARDWARE ^ 1 << bit;
        add("foreign hardware", Header { hardware, ..fits }, &keys());
    }
    for seed in 0..32 {
        let foreign = Keypair::from(&[seed + 100; 32]);
        add("foreign key", fits, &foreign);
        let number = foreign.public.to_bytes();
        let number = u32::from_le_bytes(number[..4].try_into().expect("four bytes"));
        add(
            "foreign key",
            Header {
                key: number,
                ..fits
            },
            &foreign,
        );
    }
    for length in [
        0,
        1,
        2,
        3,
        PROGRAM as u32 - 1,
        257,
        260,
        1 << 20,
        u32::MAX - 3,
        u32::MAX,
    ] {
        add("length", Header { length, ..fits }, &keys());
    }
    all
}

#[test]
fn no_damaged_old_or_foreign_image_is_installed_even_if_the_program_requests_it() {
    let all = damaged();
    let mut kinds = BTreeMap::new();
    let verifier = Remembering::new();
    for (kind, image) in &all {
        for refusal in offer(image, &verifier) {
            assert!(refusal.is_some(), "{kind}");
        }
        *kinds.entry(*kind).or_insert(0) += 1;
    }
    println!("{} images refused: {kinds:?}", all.len());
}

#[test]
fn an_unsigned_image_that_is_accepted_is_found() {
    let is_installed = |(_, image): &&(&str, Vec<u8>)| offer(image, &Unsigned).contains(&None);
    let all = damaged();
    let found = all.iter().find(is_installed).expect("the defect is found");
    println!("installed: {}", found.0);
}

#[test]
fn a_later_image_the_same_again_and_a_recovery_image_of_the_present_version_are_installed() {
    let (draft, program) = draft(PRESENT - 2, 9);
    let replaces = Version(PRESENT);
    let recovery = signed(Header { replaces, ..draft }, &program, &keys());
    for image in [image(PRESENT), image(PRESENT + 1), recovery] {
        assert_eq!(offer(&image, key()), [None, None]);
    }
}

#[test]
fn a_recovery_image_serves_once() {
    let mut flash = Model::new();
    flash.load(SMALL.slot.start(), &image(PRESENT));
    let (draft, program) = draft(PRESENT - 2, 9);
    let replaces = Version(PRESENT);
    let recovery = signed(Header { replaces, ..draft }, &program, &keys());
    let mut board = Bootloader {
        flash: &mut flash,
        layout: &SMALL,
        hardware: HARDWARE,
        verifier: key(),
    };
    let mut install = |image: &[u8]| {
        board.start(Cause::PowerOn);
        for sector in SMALL.staging.sectors {
            board.flash.erase(sector.number).expect("the supply is on");
        }
        board.flash.load(SMALL.staging.start(), image);
        board.request()?.expect("the supply is on");
        assert_eq!(
            board.start(Cause::PowerOn),
            Decision::Run { is_trial: true }
        );
        let confirmed = board.state().confirm(header(image).version);
        log::append(board.flash, &SMALL.records, &confirmed).expect("the supply is on");
        Ok(())
    };
    assert_eq!(install(&recovery), Ok(()));
    assert_eq!(install(&image(PRESENT + 1)), Ok(()));
    assert_eq!(install(&recovery), Err(Refusal::Version));
}

#[test]
fn a_board_without_a_log_runs_a_signed_slot_and_no_other() {
    let start = |image: &[u8]| {
        let mut flash = Model::new();
        flash.load(SMALL.slot.start(), image);
        let mut board = Bootloader {
            flash: &mut flash,
            layout: &SMALL,
            hardware: HARDWARE,
            verifier: key(),
        };
        let decisions = [board.start(Cause::PowerOn), board.start(Cause::PowerOn)];
        assert_eq!(decisions[0], decisions[1]);
        (decisions[0], board.state().floor)
    };
    let runs = Decision::Run { is_trial: false };
    assert_eq!(start(&image(3)), (runs, Version(3)));
    assert_eq!(start(&[]), (Decision::Wait, Version(0)));
    let (header, program) = draft(3, 1);
    assert_eq!(
        start(&assemble(&header, &program)),
        (Decision::Wait, Version(0))
    );
}

#[test]
fn a_slot_that_has_lost_a_bit_is_written_again_from_the_image_that_was_confirmed() {
    let mut flash = Model::new();
    flash.load(SMALL.staging.start(), &image(3));
    let mut damaged = image(3);
    damaged[600] ^= 1;
    flash.load(SMALL.slot.start(), &damaged);
    let identity = header(&image(3)).identity();
    let state = State::FIRST.request(identity).confirm(Version(3));
    log::append(&mut flash, &SMALL.records, &state).expect("the supply is on");
    let mut board = Bootloader {
        flash: &mut flash,
        layout: &SMALL,
        hardware: HARDWARE,
        verifier: key(),
    };
    assert_eq!(
        board.start(Cause::PowerOn),
        Decision::Run { is_trial: false }
    );
    assert_eq!(board.flash.bytes(SMALL.slot.start(), 608), image(3));
}
