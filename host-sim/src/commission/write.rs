//! The last step: range and model are written and saved as one set.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use super::baseline::BASELINE;
use super::centre::{self, ORIGIN};
use super::encoder;
use super::tuning;
use super::{CommissionError, Findings, Step, refuse};
use crate::can::client::{Client, ClientError};
use crate::can::names;
use crate::can::sdo::SdoError;

/// The objects that the motion changes.
const CHANGED: [&str; 24] = [
    "6060", "6072", "6080", "6081", "6098", "607C", "2020:3", "2020:4", "2020:5", "2020:6",
    "2020:7", "2020:8", "2020:11", "2020:12", "2030:3", "2030:5", "2031:1", "2031:2", "2031:3",
    "2031:4", "2031:5", "2031:6", "2031:7", "2031:8",
];

/// The values of the objects that a commissioning changes for its motion.
pub struct Kept {
    origin_mdeg: i64,
    range_mdeg: (i64, i64),
    values: Vec<(&'static str, String)>,
}

impl Kept {
    /// The present values.
    ///
    /// # Errors
    /// [`ClientError::Object`].
    pub fn of(client: &mut Client) -> Result<Self, ClientError> {
        let origin_mdeg = client.integer(ORIGIN)?;
        let range_mdeg = (client.integer("607D:1")?, client.integer("607D:2")?);
        let mut values = Vec::new();
        let changed = CHANGED
            .into_iter()
            .chain(encoder::OBJECTS)
            .chain(tuning::changed());
        for object in changed.chain(BASELINE) {
            let value = client.get(names::find(object)?)?;
            values.push((object, value.to_string()));
        }
        Ok(Self {
            origin_mdeg,
            range_mdeg,
            values,
        })
    }

    /// Writes them again; the drive is off. What is refused does not keep the others from being
    /// written. An origin that [`super::centre()`] has changed remains, as only a homing changes
    /// it: 607Dh then is the same range by the new positions.
    ///
    /// # Errors
    /// [`ClientError::Object`] of the first that was refused, and [`ClientError::NotNow`] where the
    /// origin is another one.
    pub fn restore(&self, client: &mut Client) -> Result<(), ClientError> {
        let range = self.restore_range(client);
        let others = self.values.iter();
        others.fold(range, |first, (object, value)| {
            let written = client.write(object, value);
            first.and(written)
        })
    }

    fn restore_range(&self, client: &mut Client) -> Result<(), ClientError> {
        let shift = centre::shift(client, self.origin_mdeg)?;
        let (low, high) = self.range_mdeg;
        write_range(client, (low + shift, high + shift))?;
        if shift == 0 {
            return Ok(());
        }
        Err(ClientError::NotNow {
            node: client.node(),
            why: "the origin 2041h:3 is not that of before",
        })
    }
}

/// A time as days since 1984-01-01 and milliseconds of the day (CiA 301, TIME_OF_DAY); 0 before.
fn time_of_day(time: SystemTime) -> (u64, u64) {
    /// From 1970-01-01: 14 years, three of them with a leap day.
    const SINCE: Duration = Duration::from_secs((14 * 365 + 3) * DAY_S);
    const DAY_S: u64 = 86_400;
    let since = time.duration_since(UNIX_EPOCH + SINCE).unwrap_or_default();
    let ms = since.as_secs() % DAY_S * 1000 + u64::from(since.subsec_millis());
    (since.as_secs() / DAY_S, ms)
}

/// Writes 607Dh.
pub(super) fn write_range(client: &mut Client, (low, high): (i64, i64)) -> Result<(), ClientError> {
    // Each write must leave the lower limit below the upper one.
    client.write("607D:1", &i32::MIN.to_string())?;
    client.write("607D:2", &high.to_string())?;
    client.write("607D:1", &low.to_string())
}

/// Writes the range, what was found, and the date of the configuration, 1020h, and saves them. The
/// flash has the old set until the save.
///
/// # Errors
/// [`CommissionError`]. The flash has the old set then, unless the actuator stays silent behind the
/// request to save.
pub fn write(client: &mut Client, findings: &Findings) -> Result<(), CommissionError> {
    let (low, high) = findings.range_mdeg;
    write_range(client, (low.into(), high.into()))?;
    for (object, value) in findings.objects() {
        client.write(object, &value.to_string())?;
    }
    // After the others: a change of the configuration clears it.
    let (days, ms) = time_of_day(SystemTime::now());
    client.write("1020:1", &days.to_string())?;
    client.write("1020:2", &ms.to_string())?;
    // A restart before it would leave a part of the old set to be saved.
    check(client, findings)?;
    // A response that is lost does not show what the flash has; each save is that of the set which
    // the actuator has.
    repeated(|| {
        let saved = client.sdo().download(0x1010, 1, b"save");
        saved.map_err(|source: SdoError| {
            let name = "1010h:01".into();
            ClientError::Object { name, source }.into()
        })
    })?;
    // A restart between the two would have saved the old set.
    repeated(|| check(client, findings))
}

/// Repeats a transfer once to which the actuator has not answered, as while it restarts.
fn repeated(
    mut transfer: impl FnMut() -> Result<(), CommissionError>,
) -> Result<(), CommissionError> {
    match transfer() {
        Err(CommissionError::Client(ClientError::Object {
            source: SdoError::Timeout(_) | SdoError::Link(_),
            ..
        })) => transfer(),
        result => result,
    }
}

/// Refuses an actuator that does not have what was written: after a restart it has the values of
/// the flash again.
fn check(client: &mut Client, findings: &Findings) -> Result<(), CommissionError> {
    let differs = |object: &str, found: &str, value: &str| {
        let why = format!(
            "{object} is {found}, expected {value}: the actuator has restarted, or another master \
             has written"
        );
        refuse(Step::Write, why)
    };
    for (object, value) in findings.positions() {
        let found = client.integer(object)?;
        if found != i64::from(value) {
            return differs(object, &found.to_string(), &value.to_string());
        }
    }
    for (object, value) in findings.objects() {
        let entry = names::find(object).map_err(ClientError::from)?;
        let found = client.get(entry)?.to_string();
        // The actuator has single precision; its integers here have fewer than 24 bits.
        let value = value as f32;
        if found.parse() != Ok(value) {
            return differs(object, &found, &value.to_string());
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_days_since_1984_and_milliseconds_of_the_day() {
        // 2000-01-01 00:00:01.500 UTC: 16 years, four of them with a leap day.
        let time = UNIX_EPOCH + Duration::from_millis(946_684_801_500);
        assert_eq!(time_of_day(time), (16 * 365 + 4, 1_500));
        assert_eq!(time_of_day(UNIX_EPOCH), (0, 0));
    }
}
