//! The recording that an actuator makes in its own memory.

use firmware::capture::Signal;

use super::client::{Client, ClientError};
use super::names::{self, Value};

/// A recording of one record in each control period, or in every n-th.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// The recorded signals.
    pub signals: Vec<Signal>,
    /// Time between two records, us.
    pub period_us: i64,
    /// The records: a value for each signal.
    pub records: Vec<Vec<i32>>,
}

impl Capture {
    /// Time of a record since the first, s.
    pub fn time_s(&self, record: usize) -> f64 {
        record as f64 * self.period_us as f64 * 1e-6
    }

    /// Uploads it from an actuator.
    ///
    /// # Errors
    /// Those of the transfers, and [`ClientError::NotNow`] while it still runs.
    pub fn upload(client: &mut Client) -> Result<Self, ClientError> {
        if matches!(client.integer("2030:2")?, 1 | 2) {
            return Err(ClientError::NotNow {
                node: client.node(),
                why: "the capture is still running; `actuator set 2030:1=0` ends it",
            });
        }
        let mut signals = Vec::new();
        for sub in 1..=8 {
            let number = client.integer(&format!("2031:{sub}"))?;
            match u8::try_from(number).ok().and_then(Signal::of_number) {
                Some(signal) => signals.push(signal),
                None => break,
            }
        }
        let period_us = client.integer("2030:8")?;
        let Value::Bytes(data) = client.get(names::find("2032")?)? else {
            return Err(ClientError::NotAnInteger("2032".into()));
        };
        let values = |record: &[u8]| {
            let (values, _) = record.as_chunks();
            values
                .iter()
                .map(|bytes| i32::from_le_bytes(*bytes))
                .collect()
        };
        let records = data.chunks_exact(4 * signals.len().max(1)).map(values);
        Ok(Self {
            records: records.collect(),
            signals,
            period_us,
        })
    }
}
