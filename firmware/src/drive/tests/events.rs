//! Every write acts, in order: the result of a sequence does not depend on its spacing.

use canopen::cia402::Cia402State;
use proptest::prelude::*;
use std::vec;

use super::*;

/// A write of an object that commands the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Write {
    Control(u16),
    Mode(i8),
    Position(i32),
}

use Write::{Control, Mode, Position};

/// A master that writes at any time between two control periods.
struct Master {
    bench: Bench,
    /// Time of the next write, us.
    time_us: u64,
    uses_pdo: bool,
}

impl Master {
    /// RPDOs 1 to 3 each have one object; by default 2 and 3 have 6040h too.
    fn new(uses_pdo: bool) -> Self {
        let mut bench = Bench::new();
        for (rpdo, object) in [(1_u16, 0x6060_0008), (2, 0x607A_0020)] {
            let (parameters, mapping) = (0x1400 + rpdo, 0x1600 + rpdo);
            let id = 0x201 + 0x100 * u32::from(rpdo);
            bench.set(parameters, 1, id | 1 << 31, 4);
            bench.set(mapping, 0, 0, 1);
            bench.set(mapping, 1, object, 4);
            bench.set(mapping, 0, 1, 1);
            bench.set(parameters, 1, id, 4);
        }
        bench.set(0x2040, 1, 0, 4);
        let time_us = bench.now_us;
        Self {
            bench,
            time_us,
            uses_pdo,
        }
    }

    /// In fault because of the encoder, whose words are valid again.
    fn after_a_fault(uses_pdo: bool) -> Self {
        let mut master = Self::new(uses_pdo);
        master.bench.enable();
        for _ in 0..50 {
            (master.bench).step_with(|samples| samples.encoder = None);
        }
        master.bench.control(0);
        master.bench.steps(50);
        master.time_us = master.bench.now_us;
        assert_eq!(master.state(), Cia402State::Fault);
        master
    }

    fn wait(&mut self, us: u64) {
        self.time_us += us;
        while self.bench.now_us + 4_000 <= self.time_us {
            self.bench.step();
        }
    }

    fn write(&mut self, write: Write) {
        let (id, index, value, size) = match write {
            Control(word) => (0x201, 0x6040_u16, u32::from(word), 2),
            Mode(mode) => (0x301, 0x6060, mode as u32, 1),
            Position(mdeg) => (0x401, 0x607A, mdeg as u32, 4),
        };
        let data = value.to_le_bytes();
        if self.uses_pdo {
            self.bench.send(id, &data[..size]);
        } else {
            let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), data);
            let command = 0x23 | (4 - size as u8) << 2;
            (self.bench).send(0x601, &[command, low, high, 0, a, b, c, d]);
            let answer = self.bench.received.last().expect("confirmed").bytes();
            assert_eq!(answer[0], 0x60, "{write:?}");
        }
    }

    /// Writes with this time behind each.
    fn write_all(&mut self, writes: &[Write], spacing_us: u64) {
        for write in writes {
            self.write(*write);
            self.wait(spacing_us);
        }
    }

    fn state(&self) -> Cia402State {
        self.bench.actuator.device.drive.outputs().motion.state
    }
}

/// Microseconds between two writes: 0 to 20 ms.
const SPACINGS_US: [u64; 12] = [
    0, 100, 500, 1_000, 1_900, 3_000, 4_000, 5_000, 7_900, 10_000, 15_000, 20_000,
];

/// Longer than the queue and all transitions take.
const PAUSE_US: u64 = 100_000;

#[test]
fn fifty_of_fifty_sequences_enable_at_every_spacing() {
    for (uses_pdo, spacing_us) in cases() {
        let mut master = Master::new(uses_pdo);
        for trial in 0..50 {
            // Every phase of the control period.
            master.wait(PAUSE_US + 1_700 * trial);
            master.write_all(&[6, 7, 15].map(Control), spacing_us);
            master.wait(PAUSE_US);
            assert_eq!(
                master.state(),
                Cia402State::OperationEnabled,
                "{spacing_us} us"
            );
            master.write(Control(0));
        }
    }
}

#[test]
fn a_sequence_right_behind_the_boot_up_enables() {
    for (uses_pdo, spacing_us) in cases() {
        let mut master = Master::new(false);
        master.bench.send(0, &[129, 1]);
        master.bench.send(0, &[1, 1]);
        master.uses_pdo = uses_pdo;
        master.write_all(&[6, 7, 15].map(Control), spacing_us);
        // Less than the time-out of commands, which is that of the power-on.
        master.wait(PAUSE_US / 2);
        let state = master.state();
        assert_eq!(state, Cia402State::OperationEnabled, "{spacing_us} us");
    }
}

#[test]
fn twenty_of_twenty_fault_resets_act_at_every_spacing() {
    for (uses_pdo, spacing_us) in cases() {
        for trial in 0..20 {
            let mut master = Master::after_a_fault(uses_pdo);
            master.wait(700 * trial);
            master.write_all(&[0x80, 0].map(Control), spacing_us);
            master.wait(PAUSE_US);
            assert_eq!(
                master.state(),
                Cia402State::SwitchOnDisabled,
                "{spacing_us} us"
            );
        }
    }
}

#[test]
fn fifty_of_fifty_set_points_act_at_every_spacing() {
    for (uses_pdo, spacing_us) in cases() {
        let mut master = Master::new(uses_pdo);
        // The mode acts before the first set-point, however close.
        master.write_all(&[6, 7, 15].map(Control), PAUSE_US);
        master.write(Mode(1));
        for trial in 0..50_i32 {
            let target = if trial % 2 == 0 { 5_000 } else { -5_000 };
            master.write_all(
                &[Position(target), Control(0x3F), Control(0x2F)],
                spacing_us,
            );
            master.wait(2 * PAUSE_US + 1_700 * trial as u64);
            let demand = master.bench.get(0x6062, 0) as i32;
            assert_eq!(demand, target, "{trial}, {spacing_us} us");
        }
    }
}

fn cases() -> impl Iterator<Item = (bool, u64)> {
    let spacings = move |uses_pdo| SPACINGS_US.into_iter().map(move |us| (uses_pdo, us));
    [false, true].into_iter().flat_map(spacings)
}

/// The coding of "shutdown" has bit 7 clear: 86h resets a fault, and commands nothing.
#[test]
fn no_command_of_the_fault_acts_behind_its_reset() {
    for (uses_pdo, spacing_us) in cases() {
        let mut master = Master::after_a_fault(uses_pdo);
        master.write_all(&[6, 0x86, 7].map(Control), spacing_us);
        master.wait(PAUSE_US);
        let state = master.state();
        assert_eq!(state, Cia402State::SwitchOnDisabled, "{spacing_us} us");
        master.write(Control(6));
        master.wait(PAUSE_US);
        assert_eq!(master.state(), Cia402State::ReadyToSwitchOn);
    }
}

#[test]
fn with_a_full_queue_an_sdo_waits_and_an_rpdo_is_refused_with_an_emcy() {
    let mut bench = Bench::new();
    // Each differs from the one before in a bit that means nothing.
    for count in 0..16 {
        bench.received.clear();
        bench.send(0x601, &[0x2B, 0x40, 0x60, 0, 6, 0x80 * (count % 2), 0, 0]);
        assert_eq!(bench.received.len(), usize::from(count < 15), "{count}");
    }
    bench.send(0x201, &[7, 0]);
    assert_eq!(bench.emergencies(), [(0x8200, 1)]);
    bench.step();
    let answer = bench
        .received
        .iter()
        .find(|frame| frame.raw_id().0 == 0x581);
    assert_eq!(answer.expect("room for one").bytes()[0], 0x60);
    bench.steps(16);
    bench.control(6);
    assert_eq!(bench.status() & 0x6F, 0x21);
}

#[test]
fn an_excitation_starts_behind_the_controlwords_that_enable() {
    let mut bench = Bench::new();
    bench.set(0x2040, 1, 0, 4);
    for word in [6, 7, 15] {
        bench.send(0x601, &[0x2B, 0x40, 0x60, 0, word, 0, 0, 0]);
    }
    bench.received.clear();
    bench.send(0x601, &[0x2F, 0x20, 0x20, 1, 1, 0, 0, 0]);
    bench.steps(6);
    let answer = (bench.received.iter()).find(|frame| frame.raw_id().0 == 0x581);
    assert_eq!(answer.expect("an answer").bytes()[0], 0x60);
}

fn write_strategy() -> impl Strategy<Value = Write> {
    let words = vec![0, 2, 6, 7, 0xF, 0x80, 0x86, 0x8F, 0x10F];
    prop_oneof![
        4 => prop::sample::select(words).prop_map(Control),
        1 => prop::sample::select(vec![1_i8, 3, 8, 9]).prop_map(Mode),
        // At rest, but a target: bit 12 of the statusword.
        1 => Just(Position(0)),
    ]
}

/// 6065h, which is locked while the drive is driven or about to be.
fn locked_strategy() -> impl Strategy<Value = Option<u32>> {
    prop_oneof![2 => Just(None), 1 => (1_000..100_000_u32).prop_map(Some)]
}

fn set_point_strategy() -> impl Strategy<Value = Write> {
    prop_oneof![
        2 => prop::sample::select(vec![0x2F, 0x3F, 0x6F, 0x7F]).prop_map(Control),
        1 => (-70..70_i32).prop_map(|deg| Position(deg * 1000)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(40),
        cases: 500,
        ..ProptestConfig::default()
    })]

    #[test]
    fn a_sequence_has_the_result_at_any_spacing_that_it_has_slowly(
        writes in prop::collection::vec((write_strategy(), 0..20_000_u64), 1..14),
        uses_pdo: bool, is_fault: bool,
    ) {
        let run = |is_slow: bool| {
            let new = if is_fault { Master::after_a_fault } else { Master::new };
            let mut master = new(uses_pdo);
            for (write, spacing_us) in &writes {
                master.write(*write);
                master.wait(if is_slow { PAUSE_US } else { *spacing_us });
            }
            master.wait(PAUSE_US);
            (master.state(), master.bench.status(), master.bench.get(0x6061, 0))
        };
        prop_assert_eq!(run(false), run(true));
    }

    #[test]
    fn a_locked_parameter_is_accepted_at_any_spacing_where_it_is_slowly(
        writes in prop::collection::vec((write_strategy(), locked_strategy(), 0..20_000_u64), 1..14),
        is_fault: bool,
    ) {
        let run = |is_slow: bool| {
            let new = if is_fault { Master::after_a_fault } else { Master::new };
            let mut master = new(false);
            let mut results = vec![];
            for (write, locked, spacing_us) in &writes {
                master.write(*write);
                if is_slow {
                    master.wait(PAUSE_US);
                }
                if let Some(window_mdeg) = locked {
                    results.push(master.bench.try_set(0x6065, 0, *window_mdeg, 4));
                    master.time_us = master.time_us.max(master.bench.now_us);
                }
                master.wait(if is_slow { PAUSE_US } else { *spacing_us });
            }
            master.wait(PAUSE_US);
            (results, master.bench.get(0x6065, 0), master.state())
        };
        prop_assert_eq!(run(false), run(true));
    }

    #[test]
    fn set_points_have_the_result_at_any_spacing_that_they_have_slowly(
        writes in prop::collection::vec((set_point_strategy(), 0..20_000_u64), 1..10),
        uses_pdo: bool,
    ) {
        let run = |is_slow: bool| {
            let mut master = Master::new(uses_pdo);
            master.write_all(&[6, 7, 15].map(Control), PAUSE_US);
            master.write(Mode(1));
            for (write, spacing_us) in &writes {
                master.write(*write);
                master.wait(if is_slow { PAUSE_US } else { *spacing_us });
            }
            master.wait(2_000_000);
            (master.state(), master.bench.get(0x6062, 0) as i32)
        };
        prop_assert_eq!(run(false), run(true));
    }
}
