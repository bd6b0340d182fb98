//! Values as text.

/// A value with the prefix of its unit, as 30.9 kohm.
///
/// Exact to four digits, which all values of parts have at most.
pub(crate) fn text(value: f64, unit: &str) -> String {
    const PREFIXES: [(f64, &str); 6] = [
        (1e3, "k"),
        (1.0, ""),
        (1e-3, "m"),
        (1e-6, "u"),
        (1e-9, "n"),
        (1e-12, "p"),
    ];
    // Below a thousandth more than the bound, for values that no binary number represents.
    let found = PREFIXES
        .iter()
        .find(|(scale, _)| value.abs() >= scale * 0.999_9);
    let (scale, prefix) = found.unwrap_or(&(1.0, ""));
    format!("{} {prefix}{unit}", number(value / scale))
}

/// A number of at most four significant digits, without zeros at its end.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    let text = format!("{value:.*}", digits.clamp(0, 12) as usize);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_prefix_that_leaves_few_digits() {
        let texts = [
            text(30_900.0, "ohm"),
            text(0.05, "ohm"),
            text(470e-6, "F"),
            text(1e-9, "F"),
            text(10.0, "ohm"),
        ];
        assert_eq!(texts, ["30.9 kohm", "50 mohm", "470 uF", "1 nF", "10 ohm"]);
        assert_eq!(number(2.068_965), "2.069");
        assert_eq!(number(1240.0), "1240");
    }
}
