//! The service password, object 2103h.

use canopen::Abort;

use super::*;

const PASSWORD: u32 = 0x1EAF_5EED;
const SAVE: u32 = u32::from_le_bytes(*b"save");
const LOAD: u32 = u32::from_le_bytes(*b"load");

const STATE: Result<(), u32> = Err(Abort::DeviceState.code());
const WRONG: Result<(), u32> = Err(Abort::Value.code());

const UNPROTECTED: u32 = 0;
const LOCKED: u32 = 1;
const OPEN: u32 = 2;

/// What the password protects, one object of each group, with a valid value.
const PROTECTED: [(u16, u8, u32); 6] = [
    (0x2100, 8, 1_500),
    (0x2101, 1, 3_000),
    (0x2102, 1, 5),
    (0x2040, 1, 200),
    (0x6065, 0, 5_000),
    (0x607D, 2, 50_000),
];

impl Bench {
    fn reset_node(&mut self) {
        self.send(0, &[129, 1]);
        self.steps(3);
    }

    fn attempt(&mut self, password: u32) -> Result<(), u32> {
        self.try_set(0x2103, 1, password, 4)
    }

    fn access(&mut self) -> u32 {
        self.get(0x2103, 2)
    }

    /// A drive whose password is stored, after a reset of the node.
    fn locked() -> Self {
        let mut bench = Self::new();
        bench.set(0x2103, 4, PASSWORD, 4);
        bench.set(0x1010, 1, SAVE, 4);
        bench.reset_node();
        assert_eq!(bench.access(), LOCKED);
        bench
    }

    /// Configures this node-ID by LSS and stores it; returns the error codes of both.
    fn lss(&mut self, node_id: u8) -> [u8; 2] {
        self.send(0x7E5, &[4, 1, 0, 0, 0, 0, 0, 0]);
        [[0x11, node_id], [0x17, 0]].map(|[command, argument]| {
            self.received.clear();
            self.send(0x7E5, &[command, argument, 0, 0, 0, 0, 0, 0]);
            self.steps(3);
            let answers = self.received.iter().map(|frame| frame.bytes());
            let mut errors = answers.filter(|bytes| bytes[0] == command);
            errors.next().expect("an answer")[1]
        })
    }
}

#[test]
fn a_drive_from_the_factory_is_open_and_takes_any_password() {
    let mut bench = Bench::new();
    assert_eq!(bench.access(), UNPROTECTED);
    for (index, sub, value) in PROTECTED {
        bench.set(index, sub, value, 4);
    }
    assert_eq!(bench.attempt(PASSWORD), Ok(()));
    assert_eq!(bench.access(), UNPROTECTED);
    assert_eq!(bench.lss(9), [0, 0]);
}

#[test]
fn a_stored_password_locks_limits_and_identity_after_each_reset_until_it_is_given() {
    let mut bench = Bench::locked();
    for (index, sub, value) in PROTECTED {
        assert_eq!(
            bench.try_set(index, sub, value, 4),
            STATE,
            "{index:x}:{sub}"
        );
    }
    assert_eq!(bench.try_set(0x2103, 4, 0, 4), STATE, "the password itself");
    bench.set_real(0x60FB, 1, 9.0);
    bench.attempt(PASSWORD).expect("the password");
    assert_eq!(bench.access(), OPEN);
    for (index, sub, value) in PROTECTED {
        bench.set(index, sub, value, 4);
    }
    bench.reset_node();
    assert_eq!(bench.access(), LOCKED);
    bench.attempt(PASSWORD).expect("the password");
    bench.attempt(0).expect("it locks");
    assert_eq!(bench.access(), LOCKED);
    assert_eq!(bench.try_set(0x2100, 8, 1_400, 4), STATE);
}

#[test]
fn a_locked_drive_is_enabled_and_moves() {
    let mut bench = Bench::locked();
    bench.set(0x6060, 0, 1, 1);
    bench.enable();
    bench.set(0x607A, 0, 10_000, 4);
    bench.control(0x3F);
    bench.until(500, |bench| bench.is_reached());
    assert!((bench.angle_mdeg() - 10_000).abs() < 500);
}

#[test]
fn the_password_does_not_open_an_enabled_drive() {
    let mut bench = Bench::locked();
    bench.enable();
    bench.attempt(PASSWORD).expect("the password");
    for (index, sub, value) in PROTECTED {
        assert_eq!(
            bench.try_set(index, sub, value, 4),
            STATE,
            "{index:x}:{sub}"
        );
    }
    assert_eq!(bench.try_set(0x2103, 4, 0, 4), STATE);
    // It stores the node-ID that is in use.
    assert_eq!(bench.lss(9), [255, 0]);
    bench.control(0);
    bench.steps(5);
    bench.set(0x2100, 8, 1_500, 4);
}

#[test]
fn neither_defaults_nor_lss_nor_an_image_pass_the_lock() {
    let mut bench = Bench::locked();
    for sub in [1, 3] {
        assert_eq!(bench.try_set(0x1011, sub, LOAD, 4), STATE);
    }
    bench.set(0x1011, 2, LOAD, 4);
    assert_eq!(bench.lss(9), [255, 2]);
    assert_eq!(bench.get(0x2102, 1), 1);
    let begin = bench.sdo([0x21, 0x50, 0x1F, 1, 0, 1, 0, 0]);
    assert_eq!(begin[0], 0x80);
    assert_eq!(begin[4..], Abort::DeviceState.code().to_le_bytes());
    assert_eq!(bench.try_set(0x1F51, 1, 1, 1), STATE);
}

#[test]
fn restored_defaults_keep_the_password_and_0_removes_it() {
    let mut bench = Bench::locked();
    bench.attempt(PASSWORD).expect("the password");
    bench.set(0x1011, 1, LOAD, 4);
    bench.reset_node();
    assert_eq!(bench.access(), LOCKED);
    bench.attempt(PASSWORD).expect("the password");
    bench.set(0x2103, 4, 0, 4);
    assert_eq!(bench.access(), UNPROTECTED);
    bench.reset_node();
    assert_eq!(bench.access(), LOCKED, "1010h has not stored it");
    bench.attempt(PASSWORD).expect("the password");
    bench.set(0x2103, 4, 0, 4);
    bench.set(0x1010, 3, SAVE, 4);
    bench.reset_node();
    assert_eq!(bench.access(), UNPROTECTED);
}

#[test]
fn the_password_is_not_readable() {
    let mut bench = Bench::locked();
    bench.attempt(PASSWORD).expect("the password");
    for sub in [1, 4] {
        assert_eq!(bench.try_get(0x2103, sub), Err(Abort::WriteOnly.code()));
    }
}

#[test]
fn the_back_off_doubles_from_1_s_to_64_s_and_refuses_even_the_password() {
    let mut bench = Bench::locked();
    for seconds in [1, 2, 4, 8, 16, 32, 64, 64] {
        assert_eq!(bench.attempt(PASSWORD ^ 1), WRONG);
        assert_eq!(bench.get(0x2103, 3), 1000 * seconds);
        // Neither another attempt nor a reset of the node changes it.
        assert_eq!(bench.attempt(PASSWORD), STATE);
        assert_eq!(bench.access(), LOCKED);
        bench.steps(250 * seconds - 1);
        assert_eq!(bench.get(0x2103, 3), 4);
        assert_eq!(bench.attempt(PASSWORD), STATE);
        bench.step();
        assert_eq!(bench.get(0x2103, 3), 0);
    }
    bench.attempt(PASSWORD).expect("the password");
    assert_eq!(bench.attempt(PASSWORD ^ 1), WRONG);
    assert_eq!(bench.get(0x2103, 3), 1000, "the password has ended it");
}

#[test]
fn a_reset_of_the_node_does_not_end_the_back_off() {
    let mut bench = Bench::locked();
    assert_eq!(bench.attempt(1), WRONG);
    bench.reset_node();
    assert_eq!(bench.attempt(PASSWORD), STATE);
    bench.steps(250);
    assert_eq!(bench.attempt(1), WRONG);
    assert_eq!(bench.get(0x2103, 3), 2000);
}
