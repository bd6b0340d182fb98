//! Inputs from which a fuzzer starts: each state of the board is reached by one of them.

use bootloader::{ACTUATOR_BOARD, HEADER_SIZE, Header, Version};

use crate::bench::VERSION;

/// Bytes of actions; the kinds are those of [`crate::action`].
#[derive(Debug, Clone, Default)]
struct Writer(Vec<u8>);

impl Writer {
    /// Numbers of the identifiers 0, 201h, 601h and 7E5h among those of the device.
    const NMT: u8 = 0;
    const RPDO_1: u8 = 3;
    const SDO: u8 = 7;
    const LSS: u8 = 9;

    fn frame(mut self, number: u8, data: &[u8]) -> Self {
        self.0.extend([number << 3, data.len() as u8]);
        self.0.extend(data);
        self
    }

    fn action(mut self, kind: u8, number: u8, data: &[u8]) -> Self {
        self.0.push(number << 3 | kind);
        self.0.extend(data);
        self
    }

    /// An expedited SDO download of this many bytes.
    fn write(self, index: u16, sub: u8, value: i32, size: u8) -> Self {
        let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
        let command = 0x23 | (4 - size) << 2;
        self.frame(Self::SDO, &[command, low, high, sub, a, b, c, d])
    }

    fn lss(self, data: [u8; 5]) -> Self {
        let [command, a, b, c, d] = data;
        self.frame(Self::LSS, &[command, a, b, c, d, 0, 0, 0])
    }

    fn periods(self, number: u8) -> Self {
        self.action(3, number, &[])
    }

    /// Controlword and target position, mdeg, by RPDO 1.
    fn control(self, word: u16, target_mdeg: i32) -> Self {
        let data = [&word.to_le_bytes()[..], &target_mdeg.to_le_bytes()].concat();
        self.frame(Self::RPDO_1, &data).periods(1)
    }

    fn enabled() -> Self {
        let started = Self::default().periods(31).frame(Self::NMT, &[1, 0]);
        let ready = started.periods(2).control(6, 0).control(7, 0);
        ready.control(15, 0).periods(8)
    }

    fn moving() -> Self {
        (0..6).fold(Self::enabled(), |writer, _| {
            writer.control(15, 60_000).periods(5)
        })
    }
}

/// Motions in the other modes: profile position, profile velocity, cyclic velocity.
fn modes() -> Writer {
    [1, 3, 9]
        .into_iter()
        .fold(Writer::enabled(), |writer, mode| {
            let set = writer.write(0x6060, 0, mode, 1).periods(2);
            let set = set.write(0x60ff, 0, 40_000, 4).control(0x0f, 40_000);
            set.control(0x1f, 40_000).periods(4).control(0x10f, 40_000)
        })
}

/// Each excitation for a short time.
fn excitations() -> Writer {
    (0..10).fold(Writer::enabled(), |writer, shape| {
        let set = writer.write(0x2020, 3, shape, 4).write(0x2020, 8, 8, 4);
        let started = set.write(0x2020, 1, 1, 1).control(15, 0).periods(4);
        started.control(15, 0).write(0x2020, 1, 0, 1)
    })
}

/// Inquiries and settings by LSS (CiA 305), fastscan among them.
fn lss() -> Writer {
    let configuration = Writer::default().periods(1).lss([4, 1, 0, 0, 0]);
    let inquired = (0x5a..0x5f).fold(configuration, |writer, command| {
        writer.lss([command, 0, 0, 0, 0])
    });
    let set = inquired.lss([17, 5, 0, 0, 0]).lss([19, 0, 4, 0, 0]);
    let stored = set.lss([23, 0, 0, 0, 0]).periods(8).lss([21, 8, 0, 0, 0]);
    let selected = (0x40..0x44).fold(stored.periods(31), |writer, command| {
        writer.lss([command, 0, 0, 0, 0])
    });
    selected.lss([4, 0, 0, 0, 0]).lss([0x51, 0, 0, 0, 0])
}

/// A block upload, a block download of an image, and one in segments (CiA 301, 7.2.4.3).
fn transfers() -> Writer {
    let sdo = |writer: Writer, data: [u8; 8]| writer.frame(Writer::SDO, &data).periods(0);
    let requests = [
        [0xa0, 0x08, 0x10, 0, 4, 0, 0, 0],
        [0xa3, 0, 0, 0, 0, 0, 0, 0],
        [0xa2, 4, 4, 0, 0, 0, 0, 0],
        [0xa1, 0, 0, 0, 0, 0, 0, 0],
        [0xc6, 0x50, 0x1f, 1, 14, 0, 0, 0],
        [1, 1, 2, 3, 4, 5, 6, 7],
        [0x82, 1, 2, 3, 4, 5, 6, 7],
        [0xc1, 0, 0, 0, 0, 0, 0, 0],
        [0x21, 0x50, 0x1f, 1, 14, 0, 0, 0],
        [0, 1, 2, 3, 4, 5, 6, 7],
        [0x11, 1, 2, 3, 4, 5, 6, 7],
        [0x40, 0x08, 0x10, 0, 0, 0, 0, 0],
        [0x60, 0, 0, 0, 0, 0, 0, 0],
        [0x70, 0, 0, 0, 0, 0, 0, 0],
    ];
    requests.into_iter().fold(Writer::default().periods(4), sdo)
}

/// A download of an image in segments, and its installation.
fn update() -> Writer {
    let header = Header {
        length: 8,
        hardware: ACTUATOR_BOARD,
        version: VERSION,
        replaces: Version::default(),
        program_crc: 0,
        key: 0,
        hash: [0; 64],
        signature: [0; 64],
    };
    let mut image = header.bytes().to_vec();
    image.resize(HEADER_SIZE as usize + header.length as usize, 0);
    let [a, b, c, d] = (image.len() as u32).to_le_bytes();
    let begun = Writer::default().periods(31);
    let begun = begun.frame(Writer::SDO, &[0x21, 0x50, 0x1f, 1, a, b, c, d]);
    let last = image.len().div_ceil(7) - 1;
    let sent = image
        .chunks(7)
        .enumerate()
        .fold(begun, |writer, (k, part)| {
            // Toggle bit, bytes without data, and the end (CiA 301, 7.2.4.3.4).
            let head = (k % 2) << 4 | (7 - part.len()) << 1 | usize::from(k == last);
            let mut data = [head as u8, 0, 0, 0, 0, 0, 0, 0];
            data[1..=part.len()].copy_from_slice(part);
            writer.frame(Writer::SDO, &data)
        });
    let staged = sent.periods(8).write(0x1f51, 1, 1, 1);
    staged.periods(31)
}

/// The inputs, each with its name.
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    let save = [0x23, 0x10, 0x10, 1, 0x73, 0x61, 0x76, 0x65];
    // CiA 402-2: 2 is "quick stop", 0 "disable voltage", bit 7 acknowledges a fault.
    let acknowledge = |writer: Writer| writer.control(0, 0).control(0x80, 0).periods(31);
    let inputs = [
        ("modes", modes()),
        ("excitations", excitations()),
        ("lss", lss()),
        ("transfers", transfers()),
        ("update", update()),
        ("enabled", Writer::enabled()),
        ("moving", Writer::moving()),
        ("quick-stop", Writer::moving().control(2, 0).periods(31)),
        ("released", Writer::moving().control(0, 0).periods(31)),
        (
            "saving",
            Writer::default()
                .periods(8)
                .frame(Writer::SDO, &save)
                .periods(8),
        ),
        (
            "encoder-lost",
            acknowledge((0..8).fold(Writer::moving(), |writer, _| writer.action(5, 7, &[]))),
        ),
        (
            "supply-low",
            acknowledge(
                Writer::moving()
                    .action(6, 7, &[0; 10])
                    .action(6, 7, &[0; 10]),
            ),
        ),
        (
            "tripped",
            acknowledge(Writer::moving().action(7, 0, &[0, 0, 1])),
        ),
        ("bus-off", Writer::moving().action(7, 7, &[0, 0, 8])),
        ("timeout", Writer::moving().periods(31).periods(31)),
        (
            "reset",
            Writer::moving().frame(Writer::NMT, &[0x81, 0]).periods(31),
        ),
    ];
    inputs.map(|(name, writer)| (name, writer.0)).into()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use firmware::application::BoardState;
    use proptest::prelude::*;

    use crate::run;

    #[test]
    fn the_first_inputs_drive_the_motor_and_reach_every_state() {
        let mut states = BTreeSet::new();
        for (name, input) in super::all() {
            let summary = run(&input);
            let enables = !["saving", "lss", "transfers", "update"].contains(&name);
            assert_eq!(summary.driven > 0, enables, "{name}: {summary:?}");
            states.extend(summary.states);
        }
        // A master's stops are ramps of the axis: the state of a quick stop is not entered.
        use BoardState::{Disabled, Enabled, Fault, FaultReaction};
        let all = [Disabled, Enabled, FaultReaction, Fault].map(|state| state as u8);
        assert_eq!(states, all.into());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1_000))]
        #[test]
        fn what_must_hold_holds_after_the_first_inputs_and_any_bytes(
            first in prop::sample::select(super::all()),
            more in prop::collection::vec(any::<u8>(), 0..600),
        ) {
            run(&[first.1, more].concat());
        }
    }
}
