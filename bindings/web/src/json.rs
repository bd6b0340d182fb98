//! JSON, as far as it is needed here: writing.

use std::fmt::Write as _;

/// A text in quotes.
pub fn text(text: &str) -> String {
    let mut json = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => json.extend(['\\', c]),
            c if c < ' ' => {
                // Writing to a string does not fail.
                let _ = write!(json, "\\u{:04x}", c as u32);
            }
            c => json.push(c),
        }
    }
    json + "\""
}

/// A number; JSON has neither infinity nor NaN: they are `null`.
pub fn number(value: f64) -> String {
    if value.is_finite() {
        value.to_string()
    } else {
        "null".into()
    }
}

/// An object of members that are JSON already.
pub fn object<'a>(members: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let members = members.into_iter();
    let members: Vec<_> = members.map(|(k, v)| format!("{}:{v}", text(k))).collect();
    format!("{{{}}}", members.join(","))
}

/// An array of elements that are JSON already.
pub fn array(elements: impl IntoIterator<Item = String>) -> String {
    let elements: Vec<_> = elements.into_iter().collect();
    format!("[{}]", elements.join(","))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn another_reader_finds_the_same_again(string in ".*", value in -1e9..1e9) {
            let json = object([("a \"name\"", array([text(&string), number(value)]))]);
            let read: serde_json::Value = serde_json::from_str(&json).unwrap();
            let list = &read["a \"name\""];
            prop_assert_eq!(list[0].as_str(), Some(string.as_str()));
            // The reader is off by a unit in the last place now and then.
            let error = list[1].as_f64().unwrap() - value;
            prop_assert!(error.abs() <= f64::EPSILON * value.abs());
        }

        #[test]
        fn a_number_is_written_to_its_last_bit_and_what_is_none_as_null(value: f64) {
            let expected = value.is_finite().then_some(value);
            prop_assert_eq!(number(value).parse().ok(), expected);
        }
    }
}
