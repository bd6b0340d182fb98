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
        fn another_reader_finds_the_same_again(string in ".*", value: f64) {
            let json = object([("a \"name\"", array([text(&string), number(value)]))]);
            let read: serde_json::Value = serde_json::from_str(&json).unwrap();
            prop_assert_eq!(read["a \"name\""][0].as_str(), Some(string.as_str()));
            match read["a \"name\""][1].as_f64() {
                // The reader is off by a unit in the last place now and then.
                Some(back) => prop_assert!((back - value).abs() <= f64::EPSILON * value.abs()),
                None => prop_assert!(!value.is_finite()),
            }
        }
    }
}
