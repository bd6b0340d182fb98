//! What the bytes of an input mean.

use canopen::CanFrame;
use firmware::application::BusState;
use firmware::dictionary::DICTIONARY;
use model_core::control::encoder_word::EncoderWord;
use model_core::sensors::adc::AdcCode;

/// An action on the device.
#[derive(Debug, Clone, Copy)]
pub enum Action {
    /// A frame on the bus.
    Frame(CanFrame),
    /// So many control periods, each with this disturbance.
    Periods(u32, Disturbance),
    /// What the next write of the flash returns.
    Flash {
        /// Whether it succeeds.
        succeeds: bool,
    },
}

/// What is not as on an undisturbed board in a control period.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disturbance {
    /// The word of the encoder, `None` where its transfer did not end.
    pub encoder: Option<Option<EncoderWord>>,
    /// Codes of the current, both legs, the supply and the temperature.
    pub codes: Option<[AdcCode; 5]>,
    /// Width of a servo pulse, us.
    pub servo_pulse_us: Option<u16>,
    /// The break input has switched the bridge off.
    pub bridge_tripped: bool,
    /// Control periods that were missed.
    pub missed_periods: u8,
    /// The duty was written too late.
    pub is_late: bool,
    /// The state of the CAN controller.
    pub bus: BusState,
}

/// Identifiers to which a device with node-ID 1 listens: NMT, SYNC, TIME, RPDOs, SDO, the heartbeat
/// of a master, LSS.
const IDENTIFIERS: [u32; 10] = [
    0, 0x80, 0x100, 0x201, 0x301, 0x401, 0x501, 0x601, 0x764, 0x7e5,
];

/// Control periods of one action at most, where nothing is disturbed and where something is.
const LONGEST: u32 = 64;
const LONGEST_DISTURBED: u32 = 8;

/// The actions of an input. An incomplete last one is filled up with zeros.
#[derive(Debug, Clone)]
pub struct Actions<'a> {
    rest: &'a [u8],
}

impl<'a> Actions<'a> {
    /// The actions of these bytes.
    pub fn new(input: &'a [u8]) -> Self {
        Self { rest: input }
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        let (taken, rest) = self.rest.split_at(self.rest.len().min(N));
        bytes[..taken.len()].copy_from_slice(taken);
        self.rest = rest;
        bytes
    }

    fn byte(&mut self) -> u8 {
        let [byte] = self.bytes();
        byte
    }

    /// As many bytes as the length of a frame says.
    fn data(&mut self) -> (u8, [u8; 8]) {
        let length = self.byte() % 9;
        let mut data = [0; 8];
        data[..usize::from(length)].fill_with(|| self.byte());
        (length, data)
    }

    /// A frame with an identifier of the device.
    fn addressed(&mut self, number: u8) -> Action {
        let id = IDENTIFIERS[usize::from(number) % IDENTIFIERS.len()];
        let (length, data) = self.data();
        frame(id, false, false, length, data)
    }

    /// An expedited SDO download to an object of the dictionary.
    fn download(&mut self) -> Action {
        let rows = DICTIONARY.entries();
        let row = usize::from(u16::from_le_bytes(self.bytes()));
        let row = &rows[row % rows.len()];
        let address = row.address();
        let [low, high] = address.index.to_le_bytes();
        let size = row.data_type().size().unwrap_or(4).clamp(1, 4);
        let mut value = [0; 4];
        value[..usize::from(size)].fill_with(|| self.byte());
        let [a, b, c, d] = value;
        let command = 0x23 | (4 - size) << 2;
        let data = [command, low, high, address.sub, a, b, c, d];
        frame(0x601, false, false, 8, data)
    }

    /// Any frame.
    fn any(&mut self) -> Action {
        let head = u32::from_le_bytes(self.bytes());
        let (extended, remote) = (head >> 31 != 0, head >> 30 & 1 != 0);
        let id = head & if extended { 0x1fff_ffff } else { 0x7ff };
        let (length, data) = self.data();
        frame(id, extended, remote, length, data)
    }

    fn codes(&mut self) -> [AdcCode; 5] {
        [(); 5].map(|()| AdcCode::new(u16::from_le_bytes(self.bytes()) & 0xfff))
    }

    /// A servo pulse, and events of a control period.
    fn events(&mut self) -> Disturbance {
        let width_us = u16::from_le_bytes(self.bytes());
        let flags = self.byte();
        Disturbance {
            servo_pulse_us: (width_us != 0).then_some(width_us),
            bridge_tripped: flags & 1 != 0,
            is_late: flags & 2 != 0,
            bus: match flags >> 2 & 3 {
                1 => BusState::Passive,
                2 => BusState::Off,
                _ => BusState::Active,
            },
            missed_periods: flags >> 4,
            ..Disturbance::default()
        }
    }

    fn disturbance(&mut self, kind: u8) -> Disturbance {
        match kind {
            4 => Disturbance {
                encoder: Some(Some(EncoderWord::new(u32::from_le_bytes(self.bytes())))),
                ..Disturbance::default()
            },
            5 => Disturbance {
                encoder: Some(None),
                ..Disturbance::default()
            },
            6 => Disturbance {
                codes: Some(self.codes()),
                ..Disturbance::default()
            },
            _ => self.events(),
        }
    }
}

fn frame(id: u32, extended: bool, remote: bool, length: u8, data: [u8; 8]) -> Action {
    let frame = CanFrame::raw(id, extended, remote, length, data);
    Action::Frame(frame.expect("an identifier in its range and at most 8 bytes"))
}

impl Iterator for Actions<'_> {
    type Item = Action;

    /// The three lowest bits of an action's first byte are its kind, the others a number.
    fn next(&mut self) -> Option<Action> {
        if self.rest.is_empty() {
            return None;
        }
        let head = self.byte();
        let number = head >> 3;
        Some(match head & 7 {
            0 => self.addressed(number),
            1 => self.download(),
            2 if number == 31 => Action::Flash {
                succeeds: self.byte() & 1 == 0,
            },
            2 => self.any(),
            3 => Action::Periods(
                (2 * u32::from(number) + 1).min(LONGEST),
                Disturbance::default(),
            ),
            kind => {
                let periods = u32::from(number) % LONGEST_DISTURBED + 1;
                Action::Periods(periods, self.disturbance(kind))
            }
        })
    }
}
