//! 1010h, 1011h and LSS over the flash.

use super::*;
use crate::store::{EDGES, Stored};
use canopen::Abort;

const SAVE: u32 = u32::from_le_bytes(*b"save");
const LOAD: u32 = u32::from_le_bytes(*b"load");

fn reset(bench: &mut Bench) {
    bench.send(0, &[129, 1]);
    bench.steps(3);
}

#[test]
fn what_is_saved_is_there_after_a_reset_and_what_is_not_is_gone() {
    let mut bench = Bench::new();
    bench.set_real(0x60FB, 1, 9.5);
    bench.set(0x6081, 0, 123_000, 4);
    bench.set(0x1017, 0, 700, 2);
    bench.set(0x1010, 1, SAVE, 4);
    bench.set(0x6081, 0, 1, 4);
    bench.set_real(0x60FB, 1, 7.0);
    reset(&mut bench);
    assert_eq!(f32::from_bits(bench.get(0x60FB, 1)), 9.5);
    assert_eq!(bench.get(0x6081, 0), 123_000);
    assert_eq!(bench.get(0x1017, 0), 700);
    bench.set(0x1011, 1, LOAD, 4);
    assert_eq!(bench.get(0x6081, 0), 123_000, "until the reset");
    reset(&mut bench);
    assert_eq!(bench.get(0x6081, 0), 300_000);
    assert_eq!(bench.get(0x1017, 0), 0);
    assert_eq!(f32::from_bits(bench.get(0x60FB, 1)), 8.0);
}

#[test]
fn groups_are_stored_apart() {
    let mut bench = Bench::new();
    bench.set(0x6081, 0, 123_000, 4);
    bench.set(0x1017, 0, 700, 2);
    bench.set(0x1010, 3, SAVE, 4);
    reset(&mut bench);
    assert_eq!((bench.get(0x6081, 0), bench.get(0x1017, 0)), (123_000, 0));
    bench.set(0x6081, 0, 5, 4);
    bench.set(0x1017, 0, 600, 2);
    bench.set(0x1010, 2, SAVE, 4);
    reset(&mut bench);
    assert_eq!((bench.get(0x6081, 0), bench.get(0x1017, 0)), (123_000, 600));
}

#[test]
fn a_flash_that_refuses_is_told() {
    let mut bench = Bench::new();
    bench.flash = Flash::Refuses;
    assert_eq!(
        bench.try_set(0x1010, 1, SAVE, 4),
        Err(Abort::Hardware.code())
    );
    assert_eq!(
        bench.try_set(0x1010, 1, 1, 4),
        Err(Abort::Store.code()),
        "a wrong signature"
    );
}

#[test]
fn lss_stores_node_id_and_bit_rate_and_a_restore_leaves_them() {
    let mut bench = Bench::new();
    bench.send(0x7E5, &[4, 1, 0, 0, 0, 0, 0, 0]);
    bench.send(0x7E5, &[0x11, 42, 0, 0, 0, 0, 0, 0]);
    bench.send(0x7E5, &[0x13, 0, 2, 0, 0, 0, 0, 0]);
    bench.heard.clear();
    bench.send(0x7E5, &[0x17, 0, 0, 0, 0, 0, 0, 0]);
    bench.steps(3);
    assert!(
        bench
            .heard
            .contains(&frame(0x7E4, &[0x17, 0, 0, 0, 0, 0, 0, 0]))
    );
    bench.set(0x1011, 1, LOAD, 4);
    let bus = bench.device.drive.store.set().board.bus;
    assert_eq!((bus.node_id, bus.bit_rate_kbit_s), (42, 500));
    bench.send(0x7E5, &[0x13, 0, 4, 0, 0, 0, 0, 0]);
    let refused = frame(0x7E4, &[0x13, 1, 0, 0, 0, 0, 0, 0]);
    assert!(bench.heard.contains(&refused), "125 kbit/s");
    bench.send(0x7E5, &[0x15, 10, 0, 0, 0, 0, 0, 0]);
    bench.steps(10);
    assert_eq!(bench.device.drive.take_bit_rate(), Some(500));
}

#[test]
fn a_set_comes_back_from_its_words_and_others_are_refused() {
    let mut set = Set::defaults();
    set.board.bus.node_id = 17;
    let mut page = Set::ZEROS;
    let words = &mut page[..Set::ZEROS.len() - EDGES];
    set.write(words);
    assert_eq!(Set::read(words), Some(set));
    words[crate::parameters::WORDS - 1] = u32::MAX;
    assert_eq!(Set::read(words), None, "a parameter out of its range");
    assert_eq!(Set::read(&words[..20]), None);
}
