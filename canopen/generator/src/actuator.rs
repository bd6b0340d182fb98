//! The files of the actuator's board.

use crate::{Device, ParseError, eds, markdown, parse, table};

/// The source, from the root of the repository.
pub const SOURCE: &str = "firmware/object-dictionary.csv";

/// Paths from the root of the repository, and what stands there.
///
/// # Errors
///
/// What is wrong in the source.
pub fn files(source: &str) -> Result<[(&'static str, String); 3], ParseError> {
    let rows = parse(source)?;
    let device = Device {
        file: "smart-actuator.eds".into(),
        description: "Smart RC-servo actuator: CiA 402 drive with capture and excitation".into(),
        vendor: "smart-actuator".into(),
        product: "SMART-ACTUATOR".into(),
        bit_rates: vec![500, 1000],
    };
    Ok([
        ("firmware/src/dictionary/table.rs", table(&rows)),
        ("docs/smart-actuator.eds", eds(&device, &rows)),
        (
            "docs/object-dictionary.md",
            markdown("Object dictionary of the actuator", &rows),
        ),
    ])
}
