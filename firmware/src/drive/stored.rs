//! What object 1010h stores.

use canopen::ParameterGroup;
use canopen::dictionary::{Address, DataType, Entry};

use super::servo_bus::Model;
use crate::{
    dictionary::{COMMUNICATION, COMMUNICATION_ENTRIES, DICTIONARY, Location, location},
    parameters::{BoardParameters, CONTROL, ObjectValue, ObjectValues, Parameter},
    store::{EDGES, Field, Stored, layout_hash},
};
use model_core::control::parameters::ControlParameters;
use model_core::parameter::Parameters;
use servo_bus::EEPROM;

/// Words of a set: control parameters, other parameters of the board, values of objects,
/// communication parameters, whether the latter are stored, and the registers of the servo bus.
const WORDS: usize =
    CONTROL + Parameter::ALL.len() + ObjectValue::ALL.len() + COMMUNICATION + 1 + REGISTERS;

/// Words of the registers of the servo bus: the model of the servo, and its EEPROM.
const REGISTERS: usize = 1 + EEPROM / 4;

/// Name or address, and type, of each word of a set.
pub(super) const LAYOUT: [Field; WORDS] = {
    let flag = Field {
        name: "has_communication",
        address: 0,
        data_type: "bool",
    };
    let mut layout = [flag; WORDS];
    let mut at = 0;
    let mut row = 0;
    while row < CONTROL {
        layout[at] = named((ControlParameters::TABLE[row].name, "f32"));
        (at, row) = (at + 1, row + 1);
    }
    let mut row = 0;
    while row < Parameter::FIELDS.len() {
        layout[at] = named(Parameter::FIELDS[row]);
        (at, row) = (at + 1, row + 1);
    }
    let mut row = 0;
    while row < ObjectValue::FIELDS.len() {
        layout[at] = named(ObjectValue::FIELDS[row]);
        (at, row) = (at + 1, row + 1);
    }
    let mut row = 0;
    while row < COMMUNICATION {
        layout[at] = communication_field(&COMMUNICATION_ENTRIES[row]);
        (at, row) = (at + 1, row + 1);
    }
    // Behind the flag.
    at += 1;
    while at < WORDS {
        layout[at] = Field {
            name: "servo_registers",
            address: at as u32,
            data_type: "u32",
        };
        at += 1;
    }
    layout
};

const fn named((name, data_type): (&'static str, &'static str)) -> Field {
    Field {
        name,
        address: 0,
        data_type,
    }
}

const fn communication_field(entry: &Entry) -> Field {
    let Address { index, sub } = entry.address();
    Field {
        name: "",
        address: (index as u32) << 8 | sub as u32,
        data_type: match entry.data_type() {
            DataType::U8 => "u8",
            DataType::U16 => "u16",
            _ => "u32",
        },
    }
}

/// All stored parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StoredParameters {
    /// The parameters of the board, node-ID and bit rate among them.
    pub board: BoardParameters,
    pub(super) values: ObjectValues,
    communication: [u32; COMMUNICATION],
    /// Whether the communication parameters are stored; if not, their defaults apply.
    has_communication: bool,
    /// The servo on the servo bus, and what its control table keeps without power.
    pub(super) registers: ServoRegisters,
}

/// The EEPROM of a control table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ServoRegisters {
    /// Number of the model, object 2102h:4; 0: nothing is stored.
    pub model: u8,
    pub eeprom: [u8; EEPROM],
}

impl ServoRegisters {
    const NONE: Self = Self {
        model: 0,
        eeprom: [0; EEPROM],
    };

    fn words(&self) -> impl Iterator<Item = u32> {
        let (words, _) = self.eeprom.as_chunks::<4>();
        let eeprom = words.iter().map(|word| u32::from_le_bytes(*word));
        [u32::from(self.model)].into_iter().chain(eeprom)
    }

    fn read(words: &mut impl Iterator<Item = u32>) -> Option<Self> {
        let mut registers = Self {
            model: u8::try_from(words.next()?).ok()?,
            ..Self::NONE
        };
        for (place, word) in registers
            .eeprom
            .as_chunks_mut::<4>()
            .0
            .iter_mut()
            .zip(words)
        {
            *place = word.to_le_bytes();
        }
        Some(registers)
    }
}

impl StoredParameters {
    /// The factory settings.
    pub const DEFAULT: Self = Self {
        board: BoardParameters::DEFAULT,
        values: ObjectValues::DEFAULT,
        communication: [0; COMMUNICATION],
        has_communication: false,
        registers: ServoRegisters::NONE,
    };

    /// These parameters, with DroneCAN on the bus: the actuator of this number, whose node-ID the
    /// network allocates.
    #[must_use]
    pub const fn with_dronecan(mut self, actuator_id: u8) -> Self {
        self.values.dronecan.protocol = DRONECAN;
        self.values.dronecan.actuator_id = actuator_id;
        self
    }

    /// Whether DroneCAN is on the bus, and not CANopen.
    pub(super) const fn has_dronecan(&self) -> bool {
        self.values.dronecan.protocol == DRONECAN
    }

    /// These parameters, as a servo of this model and ID on the servo bus.
    #[must_use]
    pub fn with_servo_bus(mut self, model: Model, id: u8) -> Self {
        self.values.servo_bus.servo_bus_model = model as u8;
        self.registers = ServoRegisters {
            model: model as u8,
            eeprom: model.eeprom(id),
        };
        self
    }

    /// The model of the servo that the board is on the servo bus.
    pub(super) fn servo_bus_model(&self) -> Option<Model> {
        Model::of_number(self.values.servo_bus.servo_bus_model)
    }

    /// The values of objects.
    pub(crate) fn values(&self) -> &ObjectValues {
        &self.values
    }

    /// The stored value of a communication parameter.
    pub(super) fn communication(&self, address: Address) -> Option<u32> {
        let stored = self.has_communication.then_some(&self.communication)?;
        let Ok(Location::Communication(position)) = DICTIONARY.find(address).map(location) else {
            return None;
        };
        let position = usize::from(position);
        let word = stored.get(position).copied()?;
        let follows_node_id = || {
            COMMUNICATION_ENTRIES
                .get(position)
                .is_some_and(Entry::has_node_id)
        };
        (word != FOLLOWS_NODE_ID || !follows_node_id()).then_some(word)
    }

    /// Takes over the present values of a group.
    pub(super) fn take(
        &mut self,
        group: ParameterGroup,
        (board, values, node_id): (&BoardParameters, &ObjectValues, u8),
        communication: impl Iterator<Item = (Address, u32)>,
    ) {
        if group.has_communication() {
            // Both are sorted by address: one pass finds every position.
            let mut words = COMMUNICATION_ENTRIES.iter().zip(&mut self.communication);
            for (address, value) in communication {
                let Some((entry, word)) = words.find(|(entry, _)| entry.address() == address)
                else {
                    break;
                };
                let is_default = entry.has_node_id() && entry.default_value(node_id) == value;
                *word = if is_default { FOLLOWS_NODE_ID } else { value };
            }
            self.has_communication = true;
        }
        if has_application(group) {
            self.board = *board;
            self.values = *values;
        }
    }

    /// Restores the defaults of a group; node-ID, bit rate, protocol and servo bus stay, or a
    /// client would lose the device, and so does the service password.
    pub(super) fn restore(&mut self, group: ParameterGroup) {
        if group.has_communication() {
            self.has_communication = false;
        }
        if has_application(group) {
            self.board = BoardParameters {
                bus: self.board.bus,
                ..BoardParameters::DEFAULT
            };
            self.values = ObjectValues {
                service: self.values.service,
                dronecan: self.values.dronecan,
                servo_bus: self.values.servo_bus,
                ..ObjectValues::DEFAULT
            };
        }
    }
}

/// The number of the protocol DroneCAN, object 2102h:3.
const DRONECAN: u8 = 1;

/// Stored instead of a COB-ID that follows the node-ID as in the dictionary; no valid COB-ID has
/// all bits set.
const FOLLOWS_NODE_ID: u32 = u32::MAX;

fn has_application(group: ParameterGroup) -> bool {
    matches!(group, ParameterGroup::All | ParameterGroup::Application)
}

impl Stored for StoredParameters {
    const LAYOUT: u32 = layout_hash(&LAYOUT);
    const DEFAULT: Self = Self::DEFAULT;
    type Page = [u32; WORDS + EDGES];
    const ZEROS: Self::Page = [0; WORDS + EDGES];

    fn write(&self, words: &mut [u32]) {
        let words = &mut words.iter_mut();
        self.board.write_words(words);
        self.values.write_words(words);
        let rest = self
            .communication
            .into_iter()
            .chain([u32::from(self.has_communication)])
            .chain(self.registers.words());
        for (word, content) in words.zip(rest) {
            *word = content;
        }
    }

    fn read(words: &[u32]) -> Option<Self> {
        let words = &mut words.iter().copied();
        let board = BoardParameters::read_words(words)?;
        let values = ObjectValues::read_words(words)?;
        let mut communication = [0; COMMUNICATION];
        for word in &mut communication {
            *word = words.next()?;
        }
        Some(Self {
            board,
            values,
            communication,
            has_communication: words.next() == Some(1),
            registers: ServoRegisters::read(words)?,
        })
    }
}
