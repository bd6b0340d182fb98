extern crate std;

use std::{format, string::String};

use super::*;
use crate::parameters::BoardParameters;

#[test]
fn numbers_match_the_positions_in_list_and_table() {
    for (index, fault) in Fault::ALL.into_iter().enumerate() {
        assert_eq!(usize::from(fault.number()), index + 1);
        assert_eq!(Fault::of_number(fault.number()), Some(fault));
        assert_eq!(TABLE[index].fault, fault);
    }
    assert_eq!(Fault::of_number(25), None);
    assert_eq!(Fault::of_number(u16::MAX), None);
}

#[test]
fn the_sets_agree_with_the_table() {
    for row in TABLE {
        let always = matches!(row.watched, Watched::Always | Watched::Start);
        assert_eq!(ALWAYS.contains(row.fault), always, "{}", row.name);
        let following = row.watched == Watched::Following;
        assert_eq!(OF_COMMANDS.contains(row.fault), following, "{}", row.name);
    }
}

/// The table of `docs/faults.md`.
fn table() -> String {
    let mut text = String::from(
        "| no. | fault | latched when | watched | reaction | detected after | safe after | error code |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for row in TABLE {
        let p = &BoardParameters::DEFAULT;
        let watched = row.watched.words();
        let end = if p.holding_faults().contains(row.fault) {
            "hold"
        } else if FaultSet::of_bits(p.stop.brake_faults as u32).contains(row.fault) {
            "brake"
        } else {
            "coast"
        };
        let reaction = match row.fault.reaction().words() {
            None => String::from(end),
            Some(before) => format!("{before}, {end}"),
        };
        let time = |ms| match row.watched {
            Watched::Start => String::from("first step"),
            _ => format!("{ms} ms"),
        };
        text += &format!(
            "| {} | {} | {} | {watched} | {reaction} | {} | {} | 0x{:04X} |\n",
            row.fault.number(),
            row.name,
            row.condition,
            time(row.fault.detected_ms(p)),
            time(row.fault.safe_ms(p)),
            row.error_code,
        );
    }
    text
}

/// The remedies of `docs/faults.md`.
fn remedies() -> String {
    let rows = TABLE.iter();
    let rows = rows.map(|row| format!("| {} | {} |\n", row.name, row.fault.remedy()));
    format!(
        "| fault | what to do |\n|---|---|\n{}",
        rows.collect::<String>()
    )
}

#[test]
fn the_document_contains_the_tables_of_the_code() {
    let document = include_str!("../../../docs/faults.md");
    for table in [table(), remedies()] {
        assert!(
            document.contains(&table),
            "docs/faults.md shall contain\n\n{table}"
        );
    }
}
