//! Transfers of any length and content, and what damages them.

use core::task::Poll;

use dronecan::{
    Application, FrameId, Identity, Kind, Level, Node, Opcode, Parameter, Reader, Settings, Status,
    Target, Telemetry, Value, crc,
};
use embedded_can::{ExtendedId, Frame, Id};
use proptest::prelude::*;
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::Rng;

/// A frame.
#[derive(Debug, Clone)]
struct Can(ExtendedId, Vec<u8>);

impl Frame for Can {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        match id.into() {
            Id::Extended(id) => Some(Self(id, data.to_vec())),
            Id::Standard(_) => None,
        }
    }
    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }
    fn is_extended(&self) -> bool {
        true
    }
    fn is_remote_frame(&self) -> bool {
        false
    }
    fn id(&self) -> Id {
        self.0.into()
    }
    fn dlc(&self) -> usize {
        self.1.len()
    }
    fn data(&self) -> &[u8] {
        &self.1
    }
}

/// Records commands.
#[derive(Default)]
struct Recorder(Vec<(u8, Target)>);

impl Application for Recorder {
    fn unique_id(&self) -> [u8; 16] {
        *b"0123456789abcdef"
    }
    fn identity(&self) -> Identity {
        Identity {
            software: (1, 2),
            hardware: (3, 4),
            name: "recorder",
        }
    }
    fn status(&self) -> Status {
        Status::default()
    }
    fn telemetry(&self) -> Telemetry {
        Telemetry {
            actuator_id: 1,
            position_rad: 0.0,
            torque_nm: 0.0,
            rate_rad_s: 0.0,
            load_pct: 0,
            supply_v: 0.0,
            current_a: 0.0,
            circuit_errors: 0,
            temperature_k: 0.0,
            is_overheated: false,
        }
    }
    fn command(&mut self, actuator_id: u8, target: Target) {
        self.0.push((actuator_id, target));
    }
    fn find(&self, _: &[u8]) -> Option<u16> {
        None
    }
    fn parameter(&mut self, _: u16) -> Option<Parameter> {
        None
    }
    fn set(&mut self, _: u16, _: Value) {}
    fn perform(&mut self, _: Opcode) -> Poll<bool> {
        Poll::Ready(true)
    }
    fn begin_update(&mut self) -> Result<(), &'static str> {
        Ok(())
    }
    fn write_update(&mut self, _: u32, _: &[u8]) -> bool {
        true
    }
    fn end_update(&mut self, _: u32) -> bool {
        true
    }
    fn cancel_update(&mut self) {}
    fn take_log(&mut self, _: &mut [u8; 32]) -> Option<(Level, usize)> {
        None
    }
}

fn node(app: &Recorder) -> Node {
    let settings = Settings {
        node_id: 42,
        status_period_us: 0,
    };
    Node::new(settings, app, 0)
}

/// The signature of `ArrayCommand`.
const SIGNATURE: u64 = 0xd8a7_4862_38ec_3af3;

/// The frames of a message of commands, made otherwise than in the crate.
fn frames(commands: &[u8]) -> Vec<Can> {
    let id = ExtendedId::new(0x0403_F20A).expect("29 bits");
    if commands.len() < 8 {
        return vec![Can(id, [commands, &[0xC5]].concat())];
    }
    let payload = [&crc(SIGNATURE, commands).to_le_bytes(), commands].concat();
    let count = payload.chunks(7).len();
    let parts = payload.chunks(7).enumerate();
    parts
        .map(|(number, part)| {
            let ends = u8::from(number == 0) << 7 | u8::from(number + 1 == count) << 6;
            Can(id, [part, &[ends | (number as u8 % 2) << 5 | 5]].concat())
        })
        .collect()
}

fn received(frames: &[Can]) -> Vec<(u8, Target)> {
    let mut app = Recorder::default();
    let mut node = node(&app);
    for frame in frames {
        node.receive(frame, 0, &mut app);
    }
    app.0
}

proptest! {
    #[test]
    fn any_commands_arrive(values in proptest::collection::vec((any::<u8>(), 0..5u8, -1000..1000i16), 0..=15)) {
        let mut bytes = Vec::new();
        for (id, kind, value) in &values {
            bytes.extend([*id, *kind]);
            bytes.extend(dronecan::float16::to_bits(f32::from(*value)).to_le_bytes());
        }
        let expected: Vec<_> = values.iter().map(|(id, kind, value)| {
            let value = f32::from(*value);
            (*id, [Target::Unitless(value), Target::Position(value), Target::Force(value),
                Target::Speed(value), Target::PulseWidth(value)][usize::from(*kind)])
        }).collect();
        prop_assert_eq!(received(&frames(&bytes)), expected);
    }

    #[test]
    fn a_damaged_transfer_of_several_frames_commands_nothing(
        bytes in proptest::collection::vec(any::<u8>(), 8..=60),
        place in any::<prop::sample::Index>(), at in 0..7usize, flip in 1..=u8::MAX, how in 0..4
    ) {
        let mut frames = frames(&bytes);
        let place = place.index(frames.len());
        match how {
            0 => {
                let last = frames[place].1.len() - 2;
                frames[place].1[at.min(last)] ^= flip;
            }
            1 => drop(frames.remove(place)),
            2 => {
                // The toggle bit: the frame counts as a repeated one.
                *frames[place].1.last_mut().expect("a tail") ^= 0x20;
            }
            _ => {
                // The transfer number.
                *frames[place].1.last_mut().expect("a tail") ^= 1;
            }
        }
        prop_assert_eq!(received(&frames), vec![]);
    }

    #[test]
    fn repeated_frames_change_nothing(bytes in proptest::collection::vec(any::<u8>(), 8..=60)) {
        let frames = frames(&bytes);
        let twice: Vec<_> = frames.iter().flat_map(|frame| [frame.clone(), frame.clone()]).collect();
        // NaN is not equal to itself.
        prop_assert_eq!(format!("{:?}", received(&twice)), format!("{:?}", received(&frames)));
    }

    #[test]
    fn any_identifier_is_that_of_its_fields(raw in 0..1u32 << 29) {
        let id = ExtendedId::new(raw).expect("29 bits");
        if let Some(fields) = FrameId::parse(id) {
            let is_anonymous = fields.source == 0;
            prop_assert!(is_anonymous || fields.raw(0) == id);
        }
    }

    #[test]
    fn no_payload_makes_a_reader_panic(bytes in proptest::collection::vec(any::<u8>(), 0..40), bits in proptest::collection::vec(0..70u32, 0..20)) {
        let mut reader = Reader::new(&bytes);
        for bits in bits {
            let _ = (reader.unsigned(bits), reader.signed(bits), reader.rest());
        }
    }
}

#[test]
fn a_transfer_that_pauses_for_too_long_is_given_up() {
    let frames = frames(&[0; 12]);
    for (pause_us, count) in [(1_999_999, 3), (2_000_001, 0)] {
        let mut app = Recorder::default();
        let mut node = node(&app);
        node.receive(&frames[0], 0, &mut app);
        node.receive(&frames[1], pause_us, &mut app);
        assert_eq!(app.0.len(), count);
    }
}

#[test]
fn the_filters_accept_what_the_node_answers_and_little_else() {
    let node = node(&Recorder::default());
    let is_accepted = |kind, source| {
        let fields = FrameId {
            priority: 7,
            kind,
            source,
        };
        let raw = fields.raw(0x1234).as_raw();
        node.filters()
            .iter()
            .any(|(id, mask)| (raw ^ id.as_raw()) & mask == 0)
    };
    let request = |service, to| Kind::Request { service, to };
    for (kind, accepted) in [
        (Kind::Message(1), true),
        (Kind::Message(1010), true),
        (Kind::Message(341), false),
        (Kind::Message(1011), false),
        (request(1, 42), true),
        (request(1, 43), false),
        (
            Kind::Response {
                service: 48,
                to: 42,
            },
            true,
        ),
    ] {
        assert_eq!(is_accepted(kind, 10), accepted, "{kind:?}");
    }
}

/// Bytes of the seeded stream of frames, their identifiers included.
const STREAM_BYTES: usize = 10_000_000;

/// A frame with random contents: half of them of a data type that the node receives, but none that
/// is a whole command, which only the CRC of the bus protects.
fn random_frame(random: &mut Pcg64Mcg) -> Can {
    const RECEIVED: [u32; 6] = [
        0x03_F200, 0x00_0100, 0x01_AA80, 0x05_AA80, 0x0B_AA80, 0x30_2A80,
    ];
    let raw = match random.next_u32() as usize % (2 * RECEIVED.len()) {
        kind if kind < RECEIVED.len() => RECEIVED[kind] | random.next_u32() & 0x1F00_0003,
        _ => random.next_u32() >> 3,
    };
    let mut bytes = random.next_u64().to_le_bytes().to_vec();
    bytes.truncate(random.next_u32() as usize % 9);
    if let (0x03_F200, Some(tail)) = (raw & 0x00FF_FF80, bytes.last_mut()) {
        *tail &= 0x7F;
    }
    Can(ExtendedId::new(raw).expect("29 bits"), bytes)
}

#[test]
fn ten_million_random_and_mutated_bytes_command_nothing_but_what_whole_transfers_do() {
    let mut random = Pcg64Mcg::new(0xd405_eca4);
    let mut app = Recorder::default();
    let mut node = node(&app);
    let (mut fed, mut now_us, mut expected) = (0, 0, 0);
    while fed < STREAM_BYTES {
        let mut sent: Vec<_> = (0..8).map(|_| random_frame(&mut random)).collect();
        let mut commands = [random.next_u64(), random.next_u64()].map(u64::to_le_bytes);
        for kind in commands.as_flattened_mut().iter_mut().skip(1).step_by(4) {
            *kind %= 5;
        }
        let mut transfer = frames(commands.as_flattened());
        if random.next_u32().is_multiple_of(2) {
            let place = random.next_u32() as usize % transfer.len();
            transfer[place].1[0] ^= 1 << (random.next_u32() % 8);
        } else {
            expected += received(&transfer).len();
        }
        // The node 10 of the transfer sends nothing else meanwhile.
        sent.retain(|frame| frame.0.as_raw() & 0x7F != 10);
        for frame in sent.iter().chain(&transfer) {
            now_us += 100;
            node.receive(frame, now_us, &mut app);
            fed += 4 + frame.1.len();
        }
        node.tick(now_us, &mut app);
        while node.transmit::<Can>().is_some() {}
    }
    assert!(expected > 100_000, "{expected}");
    assert_eq!(app.0.len(), expected);
}
