//! The bill of materials: one row a part number, with its places on the board.

use std::collections::BTreeMap;

use crate::quantity;
use crate::{Design, Part};

/// Value and rating of a part in words; empty if its number says it all.
pub(super) fn value(part: &Part) -> String {
    let value = part.value.map(|value| quantity::text(value, &part.unit));
    let tolerance = part
        .tolerance_pct
        .map(|percent| format!("{} %", quantity::number(percent)));
    let is_rated = part
        .rating
        .starts_with(|first: char| first.is_ascii_digit());
    let rating = is_rated.then(|| part.rating.clone());
    let words: Vec<String> = [value, tolerance, rating].into_iter().flatten().collect();
    words.join(" ")
}

/// A field, in quotation marks if it holds a comma.
fn field(text: &str) -> String {
    if text.contains(',') {
        format!("\"{text}\"")
    } else {
        text.to_owned()
    }
}

pub(super) fn table(design: &Design, board: &str) -> String {
    let mut rows: BTreeMap<(&str, &str), Vec<&Part>> = BTreeMap::new();
    for part in design.parts.iter().filter(|part| part.board == board) {
        rows.entry((&part.maker, &part.part_number))
            .or_default()
            .push(part);
    }
    let mut text = "quantity,manufacturer,part number,package,value,places\n".to_owned();
    for ((maker, number), parts) in rows {
        let Some(first) = parts.first() else { continue };
        let places: Vec<_> = parts.iter().map(|part| part.designator.as_str()).collect();
        let fields = [
            maker,
            number,
            &first.package,
            &value(first),
            &places.join(" "),
        ]
        .map(field);
        text += &format!("{},{}\n", parts.len(), fields.join(","));
    }
    text
}
