//! Object dictionary of the example: all services of the device and an object of each type.

use canopen::dictionary::{
    Access::{Const, Read, ReadWrite, Write},
    Address, DataType, Dictionary, Entry, Limits, Mapping, Relation, Text,
};

const fn constant(index: u16, sub: u8, data_type: DataType, value: u32) -> Entry {
    Entry::new(index, sub, data_type, Const).value(value)
}

const fn parameter(index: u16, sub: u8, data_type: DataType, value: u32) -> Entry {
    Entry::new(index, sub, data_type, ReadWrite).value(value)
}

const fn with_node_id(index: u16, sub: u8, value: u32) -> Entry {
    Entry::new(index, sub, DataType::U32, ReadWrite).value_with_node_id(value)
}

const fn measured(index: u16, sub: u8, data_type: DataType) -> Entry {
    Entry::new(index, sub, data_type, Read).mappable(Mapping::Transmit)
}

const fn commanded(index: u16, data_type: DataType) -> Entry {
    Entry::new(index, 0, data_type, ReadWrite).mappable(Mapping::Both)
}

/// Communication parameters: sub-indices 0 to 5 of an RPDO or 0 to 6 of a TPDO.
const fn communication(index: u16, cob_id: u32) -> [Entry; 6] {
    use DataType::{U8, U16};
    [
        constant(index, 0, U8, 6),
        with_node_id(index, 1, cob_id),
        parameter(index, 2, U8, 254),
        parameter(index, 3, U16, 0),
        parameter(index, 5, U16, 0),
        parameter(index, 6, U8, 0),
    ]
}

const fn mapping(index: u16, words: [u32; 3]) -> [Entry; 9] {
    use DataType::{U8, U32};
    let count = (words[0] != 0) as u32 + (words[1] != 0) as u32 + (words[2] != 0) as u32;
    [
        parameter(index, 0, U8, count),
        parameter(index, 1, U32, words[0]),
        parameter(index, 2, U32, words[1]),
        parameter(index, 3, U32, words[2]),
        parameter(index, 4, U32, 0),
        parameter(index, 5, U32, 0),
        parameter(index, 6, U32, 0),
        parameter(index, 7, U32, 0),
        parameter(index, 8, U32, 0),
    ]
}

const HISTORY: [Entry; 9] = {
    let mut entries = [Entry::new(0x1003, 0, DataType::U32, Read); 9];
    entries[0] = Entry::new(0x1003, 0, DataType::U8, ReadWrite);
    let mut sub = 1;
    while sub <= 8 {
        entries[sub as usize] = Entry::new(0x1003, sub, DataType::U32, Read);
        sub += 1;
    }
    entries
};

const GENERAL: [Entry; 36] = {
    use DataType::{Domain, U8, U16, U32, VisibleString};
    [
        constant(0x1000, 0, U32, 0x0002_0192),
        measured(0x1001, 0, U8),
        with_value(Entry::new(0x1005, 0, U32, ReadWrite), 0x80),
        parameter(0x1006, 0, U32, 0),
        parameter(0x1007, 0, U32, 0),
        Entry::new(0x1008, 0, VisibleString, Const),
        Entry::new(0x1009, 0, VisibleString, Const),
        constant(0x1010, 0, U8, 3),
        parameter(0x1010, 1, U32, 1),
        parameter(0x1010, 2, U32, 1),
        parameter(0x1010, 3, U32, 1),
        constant(0x1011, 0, U8, 3),
        parameter(0x1011, 1, U32, 1),
        parameter(0x1011, 2, U32, 1),
        parameter(0x1011, 3, U32, 1),
        parameter(0x1012, 0, U32, 0x8000_0100),
        with_node_id(0x1014, 0, 0x80),
        parameter(0x1015, 0, U16, 0),
        constant(0x1016, 0, U8, 2),
        parameter(0x1016, 1, U32, 0),
        parameter(0x1016, 2, U32, 0),
        parameter(0x1017, 0, U16, 0),
        constant(0x1018, 0, U8, 4),
        constant(0x1018, 1, U32, 0x1234),
        constant(0x1018, 2, U32, 0x5341),
        constant(0x1018, 3, U32, 0x0001_0000),
        constant(0x1018, 4, U32, 0xCAFE_F00D),
        parameter(0x1019, 0, U8, 0),
        constant(0x1020, 0, U8, 2),
        parameter(0x1020, 1, U32, 0),
        parameter(0x1020, 2, U32, 0),
        Entry::new(0x1021, 0, Domain, Read),
        constant(0x1022, 0, U8, 0),
        constant(0x1029, 0, U8, 1),
        parameter(0x1029, 1, U8, 0),
        constant(0x1200, 0, U8, 2),
    ]
};

const fn with_value(entry: Entry, value: u32) -> Entry {
    entry.value(value)
}

const SDO: [Entry; 2] = [
    Entry::new(0x1200, 1, DataType::U32, Read).value_with_node_id(0x600),
    Entry::new(0x1200, 2, DataType::U32, Read).value_with_node_id(0x580),
];

const OBJECTS: [Entry; 24] = {
    use DataType::{Domain, F32, I8, I16, I32, OctetString, U8, U16, U32, U64, VisibleString};
    [
        parameter(0x2000, 0, U8, 0).limits(&Limits::unsigned(0, 2)),
        commanded(0x2001, I16).limits(&Limits::signed(-1000, 1000)),
        Entry::new(0x2002, 0, U8, Write),
        parameter(0x2003, 0, F32, 0).limits(&Limits::real(-1.5, 1.5)),
        commanded(0x2004, U64),
        Entry::new(0x2005, 0, VisibleString, ReadWrite).value(32),
        Entry::new(0x2006, 0, OctetString, ReadWrite).value(64),
        Entry::new(0x2007, 0, U16, ReadWrite),
        Entry::new(0x2010, 0, Domain, ReadWrite),
        commanded(0x2020, U8),
        commanded(0x2021, U8),
        commanded(0x2022, U8),
        commanded(0x6040, U16),
        measured(0x6041, 0, U16),
        commanded(0x6060, I8),
        measured(0x6061, 0, I8),
        measured(0x6064, 0, I32),
        commanded(0x607A, I32),
        constant(0x607D, 0, U8, 2),
        parameter(0x607D, 1, I32, 0).guarded(),
        parameter(0x607D, 2, I32, 0).guarded(),
        commanded(0x60FF, I32),
        Entry::new(0x6402, 0, U16, ReadWrite).guarded(),
        constant(0x6502, 0, U32, 0x185),
    ]
};

const COUNT: usize = HISTORY.len() + GENERAL.len() + SDO.len() + 4 * (6 + 9) + 1 + OBJECTS.len();

const UNUSED: u32 = 1 << 31;

const ENTRIES: [Entry; COUNT] = {
    let mut table = Table {
        entries: [GENERAL[0]; COUNT],
        length: 0,
    };
    table.add(GENERAL.split_at(2).0);
    table.add(&HISTORY);
    table.add(GENERAL.split_at(2).1);
    table.add(&SDO);
    table.add(&communication(0x1400, 0x200));
    table.add(&communication(0x1401, UNUSED | 0x300));
    table.add(&mapping(0x1600, [0x6040_0010, 0x607A_0020, 0]));
    table.add(&mapping(0x1601, [0x60FF_0020, 0x6060_0008, 0]));
    table.add(&communication(0x1800, 0x4000_0180));
    table.add(&communication(0x1801, UNUSED | 0x4000_0280));
    table.add(&mapping(0x1A00, [0x6041_0010, 0x6064_0020, 0]));
    table.add(&mapping(0x1A01, [0x6041_0010, 0x6061_0008, 0x1001_0008]));
    table.add(&[parameter(0x1F80, 0, DataType::U32, 4)]);
    table.add(&OBJECTS);
    table.entries
};

struct Table {
    entries: [Entry; COUNT],
    length: usize,
}

impl Table {
    const fn add(&mut self, entries: &[Entry]) {
        let mut at = 0;
        while at < entries.len() {
            self.entries[self.length] = entries[at];
            self.length += 1;
            at += 1;
        }
    }
}

const TEXTS: &[Text] = &[
    Text {
        address: Address::new(0x1008, 0),
        text: "CANOPEN-EXAMPLE",
    },
    Text {
        address: Address::new(0x1009, 0),
        text: "PC",
    },
];

const RELATIONS: &[Relation] = &[Relation {
    lower: Address::new(0x607D, 1),
    upper: Address::new(0x607D, 2),
}];

/// The dictionary.
pub const DICTIONARY: Dictionary = match Dictionary::try_new(&ENTRIES, TEXTS, RELATIONS) {
    Ok(dictionary) => dictionary,
    Err(_) => panic!("invalid object dictionary"),
};
