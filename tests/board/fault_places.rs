//! A fault that changes a bit of the memory has to name a place that exists.

use board_tests::program::firmware;
use virtual_board::faults::{Fault, MemoryLocation, Planned};
use virtual_board::run::{Flow, Options, Script, View, run};

/// Ends the run at once.
struct Nothing;

impl Script for Nothing {
    fn at_edge(&mut self, _: &mut View<'_>) -> Flow {
        Flow::End
    }
}

/// The error of a run with this fault.
fn error(fault: Fault) -> Option<String> {
    let options = Options {
        faults: vec![Planned::at_ms(1, fault)],
        ..Options::for_ms(5)
    };
    let result = run(firmware(), options, Nothing);
    result.err().map(|error| error.to_string())
}

#[test]
fn a_fault_without_a_place_in_the_memory_is_refused_with_the_addresses_that_exist() {
    let address = MemoryLocation::Address;
    let bit = 5;
    let place = address(0x4000_641c);
    assert_eq!(
        error(Fault::FlipRam { place, bit }).as_deref(),
        Some(
            "there is no RAM at 0x4000641c, expected 0x20000000 to 0x2002ffff or 0x10000000 to \
             0x1000ffff"
        )
    );
    let place = address(0x0820_0000);
    assert_eq!(
        error(Fault::FlipFlash { place, bit }).as_deref(),
        Some("there is no flash at 0x8200000, expected 0x8000000 to 0x81fffff")
    );
    let place = MemoryLocation::Symbol("NOWHERE".into());
    let message = error(Fault::FlipRam { place, bit }).expect("an error");
    assert!(message.ends_with("has no symbol NOWHERE"), "{message}");
    // The last byte.
    let place = address(0x2002_fffc);
    assert_eq!(error(Fault::FlipRam { place, bit: 31 }), None);
}
