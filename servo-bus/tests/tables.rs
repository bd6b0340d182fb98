//! Properties of the control tables.

use servo_bus::tables::{SCS0009, STS3215, STS3250, XL330_M288, XM430_W350};
use servo_bus::{Memory, Table};

const ALL: [&Table; 5] = [&STS3215, &STS3250, &SCS0009, &XL330_M288, &XM430_W350];

#[test]
fn the_registers_of_family_and_model_are_in_the_order_of_their_addresses() {
    for table in ALL {
        let mut free = 0;
        for register in table.registers {
            let field = register.field;
            assert!(field.address >= free, "{}: {}", table.name, register.name);
            free = field.address + u16::from(field.size);
            let found = table.register(register.name);
            assert_eq!(found, Some(register), "{}: twice", table.name);
        }
        assert!(free <= table.end, "{}", table.name);
        let memory = Memory::new(table);
        assert!(memory.contains(table.end - 1, 1) && !memory.contains(table.end, 1));
    }
    // Models differ in their own registers only: 3 and 14 of an STS, 38 and 40 of a Dynamixel.
    let differ = |one: &Table, other: &Table, address: u16| {
        let at = |table: &Table| {
            table
                .registers
                .iter()
                .find(|it| it.field.address == address)
        };
        at(one) != at(other)
    };
    assert!(differ(&STS3215, &STS3250, 3) && differ(&STS3215, &STS3250, 14));
    assert!(!differ(&STS3215, &STS3250, 42));
    assert!(differ(&XL330_M288, &XM430_W350, 38) && differ(&XL330_M288, &XM430_W350, 40));
    assert!(!differ(&XL330_M288, &XM430_W350, 116));
}

#[test]
fn tables_end_behind_their_indirect_data_and_have_the_manuals_unit_of_currents() {
    assert_eq!(ALL.map(|table| table.end), [87, 87, 67, 228, 662]);
    let units = ALL.map(|table| table.current_ua);
    assert_eq!(units, [6500, 6500, 0, 1000, 2690]);
}
