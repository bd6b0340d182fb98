//! Times of day and dates as ISO 8601 and spreadsheets write them, in seconds.

/// The seconds of `2026-01-15T10:28:10.5+01:00`, since 1970 UTC; of `10:28:10.5`, since midnight.
/// `None` for other texts.
pub fn seconds(text: &str) -> Option<f64> {
    match text.split_once(['T', ' ']) {
        Some((date, time)) => {
            let (time, zone_s) = without_zone(time.trim())?;
            Some(days(date)? * 86_400.0 + time_of_day(time)? - zone_s)
        }
        None => time_of_day(text),
    }
}

/// Days since 1970-01-01 (Hinnant, "chrono-compatible low-level date algorithms").
fn days(date: &str) -> Option<f64> {
    let mut parts = date.split(['-', '/']);
    let mut next = || parts.next()?.parse::<i32>().ok();
    let (year, month, day) = (next()?, next()?, next()?);
    if !(1000..=9999).contains(&year) || !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // Years start in March, so that the leap day is the last one.
    let year = if month > 2 { year } else { year - 1 };
    let (era, year_of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    Some(f64::from(era * 146_097 + day_of_era - 719_468))
}

/// Seconds of `HH:MM:SS.fff`, with a point or a comma.
fn time_of_day(time: &str) -> Option<f64> {
    let mut parts = time.splitn(3, ':');
    let (hour, minute) = (
        parts.next()?.parse::<u8>().ok()?,
        parts.next()?.parse::<u8>().ok()?,
    );
    let second: f64 = parts.next()?.replace(',', ".").parse().ok()?;
    let is_time = minute < 60 && (0.0..61.0).contains(&second);
    is_time.then(|| f64::from(hour) * 3600.0 + f64::from(minute) * 60.0 + second)
}

/// A time of day without its zone, and the zone, s.
fn without_zone(time: &str) -> Option<(&str, f64)> {
    if let Some(time) = time.strip_suffix(['Z', 'z']) {
        return Some((time, 0.0));
    }
    let Some(place) = time.rfind(['+', '-']) else {
        return Some((time, 0.0));
    };
    let (time, zone) = time.split_at(place);
    let sign = if zone.starts_with('-') { -1.0 } else { 1.0 };
    let zone = &zone[1..];
    let (hours, minutes) = match zone.split_once(':') {
        Some(parts) => parts,
        None if zone.len() == 2 => (zone, "0"),
        None => zone.split_at_checked(2)?,
    };
    let (hours, minutes): (f64, f64) = (hours.parse().ok()?, minutes.parse().ok()?);
    Some((time.trim(), sign * (hours * 3600.0 + minutes * 60.0)))
}

#[cfg(test)]
mod tests {
    use super::seconds;

    #[test]
    fn dates_are_seconds_since_1970_and_times_seconds_since_midnight() {
        // Of `datetime.fromisoformat(...).timestamp()` of Python.
        for (text, expected) in [
            ("1970-01-01T00:00:00Z", Some(0.0)),
            ("2026-01-15T10:28:10.5+01:00", Some(1_768_469_290.5)),
            ("2026-01-15 10:28:10.5+0100", Some(1_768_469_290.5)),
            ("2024-02-29 23:59:59,25", Some(1_709_251_199.25)),
            ("10:28:10.5", Some(37_690.5)),
            ("fast", None),
            ("2024-13-01 00:00:00", None),
            ("1-2", None),
            ("T", None),
            ("2024-01-01 é+aé", None),
        ] {
            assert_eq!(seconds(text), expected, "{text}");
        }
    }
}
