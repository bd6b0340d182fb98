//! The values that an actuator sends in its TPDOs, by the mapping that it reports.

use canopen::CanFrame;
use canopen_generator::Row;
use embedded_can::Frame;

use super::client::{Client, ClientError};
use super::names::{self, Value};

/// Position demand value, CiA 402: the command of the position loop.
const DEMAND: u16 = 0x6062;

/// TPDOs of an actuator.
const TPDOS: u16 = 4;

/// A quantity in a common unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name, which ends in its unit.
    pub name: String,
    row: &'static Row,
    /// Factor from the unit of the object to that of the name.
    factor: f64,
}

impl Column {
    fn of(row: &'static Row) -> Self {
        let name = match row.sub {
            // The name that files of all commands have for it.
            _ if row.index == DEMAND => "command",
            None => &row.object,
            Some(_) => &row.entry,
        };
        let name = name.replace([' ', '-'], "_").to_ascii_lowercase();
        let (unit, factor) = common_unit(&row.unit);
        Self {
            name: format!("{name}{unit}"),
            row,
            factor,
        }
    }

    /// The value of the object in this unit.
    fn value(&self, bytes: &[u8]) -> Option<f64> {
        match names::decode(self.row.kind, bytes)? {
            // Divided by the whole reciprocal: 1234 hundredths are exactly 12.34.
            Value::Integer(value) if self.factor < 1.0 => {
                Some(value as f64 / (1.0 / self.factor).round())
            }
            Value::Integer(value) => Some(value as f64),
            Value::Real(value) => Some(f64::from(value)),
            Value::Text(_) | Value::Bytes(_) => None,
        }
    }
}

/// The suffix of a name for a unit of the dictionary, and the factor to that unit.
fn common_unit(unit: &str) -> (&'static str, f64) {
    match unit {
        "0.01 deg" => ("_deg", 0.01),
        "mdeg" => ("_deg", 1e-3),
        "0.1 deg/s" => ("_deg_s", 0.1),
        "mdeg/s" => ("_deg_s", 1e-3),
        "deg" => ("_deg", 1.0),
        "deg/s" => ("_deg_s", 1.0),
        "mV" => ("_mv", 1.0),
        "mA" => ("_ma", 1.0),
        "0.01 %" => ("_pct", 0.01),
        "0.1 degC" => ("_deg_c", 0.1),
        "us" => ("_us", 1.0),
        "ms" => ("_ms", 1.0),
        _ => ("", 1.0),
    }
}

/// One TPDO.
#[derive(Debug, Clone)]
struct Tpdo {
    id: u32,
    /// In ms; 0 if disabled.
    event_timer: i64,
    /// Index of the column and size in bytes of each mapped object.
    entries: Vec<(usize, usize)>,
}

/// All TPDOs of an actuator.
#[derive(Debug, Clone)]
pub struct Telemetry {
    /// The mapped quantities.
    pub columns: Vec<Column>,
    tpdos: Vec<Tpdo>,
    values: Vec<f64>,
}

impl Telemetry {
    /// Reads the mapping from the actuator.
    ///
    /// # Errors
    /// Those of the transfers, [`ClientError::NoTpdo`], and [`ClientError::Request`] for a mapped
    /// object that is not in the dictionary.
    pub fn of(client: &mut Client) -> Result<Self, ClientError> {
        let mut telemetry = Self {
            columns: Vec::new(),
            tpdos: Vec::new(),
            values: Vec::new(),
        };
        for number in 0..TPDOS {
            let communication = 0x1800 + number;
            let id = client.integer(&format!("{communication:04X}:1"))? as u32;
            if id & 1 << 31 == 0 {
                let event_timer = client.integer(&format!("{communication:04X}:5"))?;
                let entries = telemetry.map(client, 0x1A00 + number)?;
                telemetry.tpdos.push(Tpdo {
                    id: id & 0x1FFF_FFFF,
                    event_timer,
                    entries,
                });
            }
        }
        if telemetry.columns.is_empty() {
            return Err(ClientError::NoTpdo);
        }
        telemetry.values = vec![f64::NAN; telemetry.columns.len()];
        Ok(telemetry)
    }

    fn map(&mut self, client: &mut Client, index: u16) -> Result<Vec<(usize, usize)>, ClientError> {
        let count = client.integer(&format!("{index:04X}:0"))?;
        let mut entries = Vec::new();
        for sub in 1..=count {
            let word = client.integer(&format!("{index:04X}:{sub}"))? as u32;
            let row = names::find(&format!("{:04X}:{}", word >> 16, word >> 8 & 0xFF))?;
            // An object such as the statusword may be mapped twice.
            let known = self.columns.iter().position(|column| column.row == row);
            let column = known.unwrap_or_else(|| {
                self.columns.push(Column::of(row));
                self.columns.len() - 1
            });
            entries.push((column, (word as usize & 0xFF) / 8));
        }
        Ok(entries)
    }

    /// Receives a frame. Returns whether it completes a record: it is the last of the TPDOs with
    /// the shortest event timer.
    pub fn receive(&mut self, frame: &CanFrame) -> bool {
        let (id, _) = frame.raw_id();
        let Some(tpdo) = self.tpdos.iter().find(|tpdo| tpdo.id == id) else {
            return false;
        };
        let mut rest = frame.data();
        for (column, size) in &tpdo.entries {
            let Some((bytes, after)) = rest.split_at_checked(*size) else {
                return false;
            };
            if let Some(value) = self.columns[*column].value(bytes) {
                self.values[*column] = value;
            }
            rest = after;
        }
        let timers = self.tpdos.iter().map(|tpdo| tpdo.event_timer);
        let fastest = timers.filter(|timer| *timer > 0).min();
        let last = self
            .tpdos
            .iter()
            .rev()
            .find(|tpdo| Some(tpdo.event_timer) == fastest);
        last.is_none_or(|last| last.id == id)
    }

    /// The names and values of the objects in a frame; `None` if it is no TPDO of the actuator.
    pub fn content(&self, frame: &CanFrame) -> Option<Vec<(&str, f64)>> {
        let (id, _) = frame.raw_id();
        let tpdo = self.tpdos.iter().find(|tpdo| tpdo.id == id)?;
        let mut rest = frame.data();
        let mut content = Vec::new();
        for (column, size) in &tpdo.entries {
            let (bytes, after) = rest.split_at_checked(*size)?;
            let column = self.columns.get(*column)?;
            content.push((column.name.as_str(), column.value(bytes)?));
            rest = after;
        }
        Some(content)
    }

    /// The last value of each column; NaN before the first.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The column by the start of its name.
    pub fn position(&self, name: &str) -> Option<usize> {
        let mut columns = self.columns.iter();
        columns.position(|column| column.name.starts_with(name))
    }

    /// The value of a column by the start of its name.
    pub fn value(&self, name: &str) -> Option<f64> {
        let at = self.position(name)?;
        Some(self.values[at]).filter(|value| value.is_finite())
    }
}

/// Time from the 16-bit sample counter, and the number of lost samples.
#[derive(Debug, Clone, Copy, Default)]
pub struct Clock {
    last: Option<u16>,
    periods: u64,
    /// Samples that did not arrive.
    pub lost: u64,
}

impl Clock {
    /// The time of a sample since the first one, s.
    ///
    /// ```
    /// let mut clock = host_sim::can::telemetry::Clock::default();
    /// let times = [65_535, 0, 3].map(|counter| clock.time_s(counter));
    /// assert_eq!(times, [0.0, 0.004, 0.016]);
    /// assert_eq!(clock.lost, 2);
    /// ```
    pub fn time_s(&mut self, counter: u16) -> f64 {
        let step = self.last.map_or(0, |last| counter.wrapping_sub(last));
        self.lost += u64::from(step.saturating_sub(1));
        self.periods += u64::from(step);
        self.last = Some(counter);
        self.periods as f64 / f64::from(model_core::time::CONTROL_RATE_HZ)
    }
}
