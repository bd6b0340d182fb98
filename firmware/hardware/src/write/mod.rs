//! Writes what is generated from the design.

mod bom;
mod markdown;
mod rust;
mod schematic;
mod symbols;

use std::path::Path;
use std::{fs, io};

use crate::Design;

/// The document with generated tables.
const DOCUMENT: &str = "docs/hardware.md";

/// Path from the workspace's folder and content of each generated file. Text between the tables of
/// the document stays as it is.
///
/// # Errors
/// If the document cannot be read, or lacks a marker of a table.
pub fn files(design: &Design, workspace: &Path) -> io::Result<Vec<(&'static str, String)>> {
    let document = fs::read_to_string(workspace.join(DOCUMENT))?;
    let document = markdown::with_tables(design, &document)
        .map_err(|missing| io::Error::other(format!("{DOCUMENT}: {missing}")))?;
    Ok(vec![
        (DOCUMENT, document),
        (
            "docs/hardware/actuator-board.svg",
            schematic::drawing(design, "actuator"),
        ),
        (
            "docs/hardware/communication-board.svg",
            schematic::drawing(design, "comm"),
        ),
        (
            "docs/hardware/actuator-board-parts.csv",
            bom::table(design, "actuator"),
        ),
        (
            "docs/hardware/communication-board-parts.csv",
            bom::table(design, "comm"),
        ),
        (
            "model-core/src/sensors/board_figures.rs",
            rust::figures(design),
        ),
        (rust::ACTUATOR_PINS, rust::pins(design, "actuator")),
        (rust::COMM_PINS, rust::pins(design, "comm")),
    ])
}
