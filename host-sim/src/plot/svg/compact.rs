//! Shorter numbers and paths in a drawing.

/// Decimals of a coordinate, which is in pixels: a hundredth is not visible at any size in print.
const DECIMALS: usize = 2;

/// The drawing with coordinates of at most two decimals, and paths that do not repeat `L`. Text
/// between the tags stays as it is; attributes contain no text.
pub fn compact(svg: &str) -> String {
    let mut out = String::with_capacity(svg.len());
    let mut rest = svg;
    while let Some(begin) = rest.find('<') {
        let end = rest[begin..]
            .find('>')
            .map_or(rest.len(), |end| begin + end);
        out += &rest[..begin];
        tag(&rest[begin..end], &mut out);
        rest = &rest[end..];
    }
    out + rest
}

/// A tag up to its end.
fn tag(text: &str, out: &mut String) {
    let mut is_in_line = false;
    for (index, word) in text.split(' ').enumerate() {
        // `L 1 2 L 3 4` is `L 1 2 3 4`.
        if word == "L" && std::mem::replace(&mut is_in_line, true) {
            continue;
        }
        if word.starts_with(|c: char| c.is_ascii_alphabetic() && c != 'L') {
            is_in_line = false;
        }
        if index > 0 {
            out.push(' ');
        }
        numbers(word, out);
    }
}

/// A word with all numbers in it rounded.
fn numbers(word: &str, out: &mut String) {
    let mut rest = word;
    while let Some(point) = rest.find('.') {
        let decimals = &rest[point + 1..];
        let count = decimals.bytes().take_while(u8::is_ascii_digit).count();
        let whole = rest[..point].bytes().rev();
        let whole = whole.take_while(u8::is_ascii_digit).count();
        let (begin, end) = (point - whole, point + 1 + count);
        let is_negative = rest[..begin].ends_with('-');
        let number = rest[begin - usize::from(is_negative)..end].parse::<f64>();
        match number {
            Ok(number) if count > DECIMALS => {
                out.push_str(&rest[..begin - usize::from(is_negative)]);
                let rounded = format!("{number:.DECIMALS$}");
                let rounded = rounded.trim_end_matches('0').trim_end_matches('.');
                out.push_str(if rounded == "-0" { "0" } else { rounded });
            }
            _ => out.push_str(&rest[..end]),
        }
        rest = &rest[end..];
    }
    out.push_str(rest);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_rounded_and_text_is_not() {
        let svg = r#"<path d="M 78 102 L 122.2 169.95000000000002 L -0.001 -1.001 L 3 4" w="1.6" />0.12345 L 1 L 2<g t="translate(0,12.3456)">"#;
        let expected = r#"<path d="M 78 102 L 122.2 169.95 0 -1 3 4" w="1.6" />0.12345 L 1 L 2<g t="translate(0,12.35)">"#;
        assert_eq!(compact(svg), expected);
    }

    #[test]
    fn a_line_after_a_new_start_is_a_line() {
        let svg = r#"<path d="M 1 2 L 3 4 M 5 6 L 7 8"/>"#;
        assert_eq!(compact(svg), svg);
    }
}
