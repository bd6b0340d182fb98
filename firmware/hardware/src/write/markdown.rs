//! The tables of the document.

use crate::design::LOGIC_V;
use crate::quantity::{self, number};
use crate::{Design, ProcessorPin};

/// The text with every table written anew.
pub(super) fn with_tables(design: &Design, text: &str) -> Result<String, String> {
    let tables = [
        ("pins of the actuator board", pins(design, "actuator")),
        ("pins of the communication board", pins(design, "comm")),
        ("ranges", ranges(design)),
    ];
    let mut text = text.to_owned();
    for (name, table) in tables {
        text = replaced(&text, name, &table)?;
    }
    Ok(text)
}

fn replaced(text: &str, name: &str, table: &str) -> Result<String, String> {
    let begin = format!("<!-- generated: {name} -->\n");
    let end = format!("<!-- end: {name} -->\n");
    let missing = |marker: &str| format!("no line {}", marker.trim_end());
    let (before, rest) = text.split_once(&begin).ok_or_else(|| missing(&begin))?;
    let (_, after) = rest.split_once(&end).ok_or_else(|| missing(&end))?;
    Ok(format!("{before}{begin}\n{table}\n{end}{after}"))
}

fn table(header: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let line = |cells: &[String]| {
        // An empty cell is one space wide.
        let cells = cells.iter().map(|cell| {
            if cell.is_empty() {
                " ".to_owned()
            } else {
                format!(" {cell} ")
            }
        });
        format!("|{}|\n", cells.collect::<Vec<_>>().join("|"))
    };
    let header: Vec<String> = header.iter().map(|&cell| cell.to_owned()).collect();
    let rule = format!("|{}\n", "---|".repeat(header.len()));
    line(&header) + &rule + &rows.map(|row| line(&row)).collect::<String>()
}

/// A text with the values of the parts and figures that it names in braces.
fn filled(design: &Design, text: &str) -> String {
    let mut pieces = text.split(['{', '}']);
    let mut filled = pieces.next().unwrap_or_default().to_owned();
    while let Some(name) = pieces.next() {
        filled += &match name {
            "current gain" => number(design.current_gain_v_a()),
            "current offset" => number(LOGIC_V / 2.0),
            "leg divider" => number(1.0 / design.leg_a_divider().ratio()),
            "supply divider" => number(1.0 / design.supply_divider().ratio()),
            "B value" => number(design.figure("RT1", "b_value")),
            part => quantity::text(design.value(part), "ohm"),
        };
        filled += pieces.next().unwrap_or_default();
    }
    filled
}

fn pins(design: &Design, board: &str) -> String {
    let row = |pin: &ProcessorPin| {
        let at = design.connectors.iter().find(|row| row.name == pin.pin);
        let place = at.map_or(String::new(), |at| match at.zio.as_str() {
            "" => at.morpho.clone(),
            zio => format!("{} ({zio})", at.morpho),
        });
        let peripheral = match pin.alternate {
            Some(number) => format!("{}, AF{number}", pin.peripheral),
            None => pin.peripheral.clone(),
        };
        vec![
            pin.function.clone(),
            pin.pin.clone(),
            place,
            peripheral,
            pin.pull.clone(),
            filled(design, &pin.outside),
        ]
    };
    let pins = design.processor.iter().filter(|pin| pin.board == board);
    table(
        &[
            "function",
            "pin",
            "Morpho (Zio)",
            "peripheral",
            "pull",
            "outside",
        ],
        pins.map(row),
    )
}

fn ranges(design: &Design) -> String {
    let volts = |value: f64| format!("{value:.2} V");
    let limit = |name: &str| {
        let limit = design.limit(name);
        limit.map_or(String::new(), |limit| {
            format!(
                "`{}` {}, at most {} {}",
                limit.name, limit.default, limit.max, limit.unit
            )
        })
    };
    let supply = design.range("actuator", "VM");
    let [low, high, surge] = supply.map_or([f64::NAN; 3], |range| {
        [range.low_v, range.high_v, range.surge_v]
    });
    let (trip_low, trip_high) = design.trip_range_a();
    let (vm, leg) = (design.supply_divider(), design.leg_a_divider());
    let rows = [
        [
            "VM while the program drives".to_owned(),
            format!(
                "{} to {}, {} in D1 for a moment",
                volts(low),
                volts(high),
                volts(surge)
            ),
            format!(
                "{}; {}",
                limit("under_voltage_mv"),
                limit("over_voltage_mv")
            ),
        ],
        [
            "VM as measured".to_owned(),
            format!(
                "1/{} of it, to {}, +-{:.1} %",
                number(1.0 / vm.ratio()),
                volts(LOGIC_V / vm.ratio()),
                design.supply_error() * 100.0
            ),
            limit("over_voltage_mv"),
        ],
        [
            "motor current".to_owned(),
            format!(
                "{} V/A around {} V, to {:.2} A",
                number(design.current_gain_v_a()),
                number(LOGIC_V / 2.0),
                design.greatest_current_a()
            ),
            limit("over_current_ma"),
        ],
        [
            "each leg".to_owned(),
            format!(
                "1/{} of it, to {}",
                number(1.0 / leg.ratio()),
                volts(LOGIC_V / leg.ratio())
            ),
            String::new(),
        ],
        [
            "trip of the comparator".to_owned(),
            format!(
                "{:.2} A, {trip_low:.2} to {trip_high:.2} A",
                design.trip_a()
            ),
            limit("over_current_ma"),
        ],
    ];
    table(
        &["quantity", "range", "limits of the program"],
        rows.into_iter().map(Vec::from),
    )
}
