//! Tests through the registers, as a firmware uses the flash.

mod bench;

use bench::*;

#[test]
fn after_a_reset_the_registers_are_locked_and_a_store_is_an_error() {
    let mut bench = Bench::new();
    bench.write(CR, 1);
    assert_eq!(bench.read(CR), 1 << 31);
    bench.store(PAGE, 1);
    assert_eq!(bench.read(SR), PGSERR);
    bench.write(SR, PGSERR);
    assert_eq!(bench.read(SR), 0);
    assert_eq!(bench.array(PAGE), u64::from(u32::MAX));
}

#[test]
fn a_wrong_key_locks_until_the_next_reset() {
    let mut bench = Bench::new();
    bench.write(KEYR, KEYS[0]);
    bench.write(KEYR, KEYS[0]);
    bench.unlock();
    assert_eq!(bench.read(CR), 1 << 31);
    assert_eq!(bench.reports(), 3);
}

#[test]
fn a_word_is_programmed_in_its_time_and_only_clears_bits() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PG | X32);
    bench.store(PAGE, 0xffff_00ff);
    assert_eq!(bench.read(SR), BSY);
    bench.run_us(15);
    assert_eq!(bench.read(SR), BSY);
    assert_eq!(bench.array(PAGE), 0xffff_ffff);
    bench.run_us(2);
    assert_eq!(bench.read(SR), 0);
    bench.store(PAGE, 0x1234_5678);
    bench.run_us(20);
    assert_eq!(bench.array(PAGE), 0x1234_5678 & 0xffff_00ff);
    assert_eq!(bench.reports(), 0);
}

#[test]
fn the_end_is_flagged_where_its_interrupt_is_enabled() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PG | X32 | EOPIE);
    bench.store(PAGE, 0);
    bench.run_us(20);
    assert_eq!(bench.read(SR), EOP);
    assert!(bench.line());
    bench.write(SR, EOP);
    assert!(!bench.line());
}

#[test]
fn stores_of_another_width_or_without_alignment_or_mode_are_errors() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PG);
    bench.store(PAGE, 0);
    assert_eq!(bench.read(SR), PGPERR);
    bench.write(SR, 0xff);
    bench.write(CR, PG | X32);
    bench.store(PAGE + 2, 0);
    assert_eq!(bench.read(SR), PGAERR);
    bench.write(SR, 0xff);
    bench.write(CR, PG | SER | X32);
    bench.store(PAGE, 0);
    assert_eq!(bench.read(SR), PGSERR);
    assert_eq!(bench.array(PAGE), u64::from(u32::MAX));
}

#[test]
fn an_error_is_summed_up_where_its_interrupt_is_enabled() {
    let mut bench = Bench::unlocked();
    bench.write(CR, X32 | ERRIE);
    bench.store(PAGE, 0);
    assert_eq!(bench.read(SR), PGSERR | OPERR);
    assert!(bench.line());
}

#[test]
fn a_sector_is_erased_in_its_time_and_its_neighbours_are_unchanged() {
    let mut bench = Bench::unlocked();
    for address in [PAGE, PAGE + 0x3ffc, PAGE + 0x4000] {
        bench.write(CR, PG | X32);
        bench.store(address, 5);
        bench.run_us(20);
    }
    // Sector 12 is number 16 of the register.
    bench.write(CR, SER | 16 << 3 | X32 | STRT);
    bench.run_us(249_000);
    assert_eq!(bench.read(SR), BSY);
    bench.run_us(2_000);
    assert_eq!(bench.read(SR), 0);
    assert_eq!(bench.read(CR) & STRT, 0);
    let cells = [PAGE, PAGE + 0x3ffc, PAGE + 0x4000].map(|address| bench.array(address));
    assert_eq!(cells, [0xffff_ffff, 0xffff_ffff, 5]);
}

#[test]
fn a_sector_that_does_not_exist_is_protected() {
    let mut bench = Bench::unlocked();
    bench.write(CR, SER | 12 << 3 | X32 | STRT);
    assert_eq!(bench.read(SR), WRPERR);
    assert_eq!(bench.read(CR) & STRT, 0);
}

#[test]
fn a_bank_is_erased_as_a_whole_and_alone() {
    let mut bench = Bench::unlocked();
    for address in [BASE, PAGE + 0xf_fffc] {
        bench.write(CR, PG | X32);
        bench.store(address, 5);
        bench.run_us(20);
    }
    bench.write(CR, 1 << 15 | X32 | STRT);
    bench.run_us(8_001_000);
    assert_eq!(
        [BASE, PAGE + 0xf_fffc].map(|a| bench.array(a)),
        [5, 0xffff_ffff]
    );
}

#[test]
fn an_operation_on_bank_1_stalls_the_core_and_one_on_bank_2_does_not() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PG | X32);
    bench.store(BASE + 0x1_0000, 0);
    assert!(bench.part.model.stalls_core());
    bench.run_us(20);
    bench.store(PAGE, 0);
    assert!(!bench.part.model.stalls_core());
}

#[test]
fn an_access_that_would_stall_the_core_is_reported() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PG | X32);
    bench.store(PAGE, 0);
    bench.store(PAGE + 4, 0);
    assert_eq!(bench.reports(), 1);
    bench.run_us(20);
    assert_eq!(bench.array(PAGE + 4), 0xffff_ffff);
}

#[test]
fn a_supply_cut_while_a_word_is_programmed_changes_only_some_of_its_bits() {
    let mut bench = Bench::unlocked();
    bench.part.model.cut_during(1, 500);
    bench.write(CR, PG | X32);
    bench.store(PAGE, 0x1111_1111);
    bench.run_us(20);
    bench.store(PAGE + 4, 0);
    bench.run_us(20);
    assert_eq!(bench.power(), Some(false));
    let left = bench.array(PAGE + 4);
    assert!(left != 0 && left != 0xffff_ffff, "{left:x}");
    assert_eq!(bench.array(PAGE), 0x1111_1111);
}

#[test]
fn a_supply_cut_during_an_erase_leaves_partly_erased_words() {
    let mut bench = Bench::unlocked();
    bench.write(CR, PG | X32);
    bench.store(PAGE, 0);
    bench.run_us(20);
    bench.part.model.cut_during(0, 300);
    bench.write(CR, SER | 16 << 3 | X32 | STRT);
    bench.run_us(80_000);
    assert_eq!(bench.power(), Some(false));
    let left = bench.array(PAGE);
    assert!(left != 0 && left != 0xffff_ffff, "{left:x}");
    assert_eq!(
        bench.array(PAGE + 8),
        0xffff_ffff,
        "an erased word stays erased"
    );
}
