//! Text within XML and HTML.

use std::fmt;

/// Shows a text so that it can stand between tags and within double quotes.
pub struct Escaped<'a>(pub &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for character in self.0.chars() {
            match character {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                other => write!(f, "{other}")?,
            }
        }
        Ok(())
    }
}

/// A number as XML Schema has it, with as many digits as bring it back exactly.
pub struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_infinite() {
            f.write_str(if self.0 > 0.0 { "INF" } else { "-INF" })
        } else {
            write!(f, "{}", self.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Escaped, Number};

    #[test]
    fn what_means_something_in_xml_is_escaped() {
        assert_eq!(
            Escaped("a<b & \"c\">").to_string(),
            "a&lt;b &amp; &quot;c&quot;&gt;"
        );
    }

    #[test]
    fn infinity_is_spelled_as_xml_schema_has_it() {
        assert_eq!(Number(f64::NEG_INFINITY).to_string(), "-INF");
        assert_eq!(Number(0.0175).to_string(), "0.0175");
    }
}
