//! `actuator record`: telemetry or the board's own capture into a CSV file.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::Args;
use serde_json::json;

use super::{AtNode, length, print_json, telemetry::watch};
use crate::error::Error;
use crate::interrupt;
use crate::output::{is_standard_output, write_error};
use host_sim::can::capture::Capture;
use host_sim::can::client::{Client, ClientError};
use host_sim::can::mapped::{Changes, restore};
use host_sim::can::telemetry::{Clock, Telemetry};

/// Records the telemetry of an actuator as a CSV file with units in the names of the columns
///
/// The command of the position loop is recorded too, by a fourth TPDO that is removed at the end.
/// An interrupt (Ctrl-C) ends the recording; the file has all samples until then. Of a servo it
/// reads goal and present values as fast as the bus allows.
///
/// With --json standard output is JSON: one object per sample and line or, if the samples go to a
/// file, the numbers of samples and of lost ones.
#[derive(Debug, Args)]
pub struct Record {
    /// CSV file; `-` for standard output
    #[arg(long, short, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    /// Duration, s
    #[arg(long = "for", value_name = "SECONDS", default_value_t = 10.0)]
    seconds: f64,
    /// Uploads the capture of the board, recorded in each control period, instead of recording
    /// telemetry
    #[arg(long, conflicts_with = "seconds")]
    capture: bool,
    #[command(flatten)]
    at: AtNode,
}

impl Record {
    /// Records.
    ///
    /// # Errors
    /// For a file that cannot be written; those of the bus and the actuator.
    pub fn run(&self) -> Result<(), Error> {
        let time = length("--for", self.seconds)?;
        let sink = || Sink::open(self.out.clone(), self.at.json());
        let (lost, sink) = match self.at.servo()? {
            Some(_) if self.capture => {
                return Err(Error::Conflict("--capture: servos have none".into()));
            }
            Some(mut servo) => {
                let mut sink = sink()?;
                (servo.record(time, &mut sink)?, sink)
            }
            None => {
                let mut client = self.at.open()?;
                let mut sink = sink()?;
                (self.record(&mut client, time, &mut sink)?, sink)
            }
        };
        let rows = sink.close()?;
        if lost > 0 {
            note!("warning: {lost} samples did not arrive: the bus or this computer was too slow");
        }
        if self.at.json() && !is_standard_output(&self.out) {
            print_json(&json!({ "rows": rows, "lost": lost }))?;
        }
        Ok(())
    }
}

impl Record {
    fn record(&self, client: &mut Client, time: Duration, sink: &mut Sink) -> Result<u64, Error> {
        if !self.capture {
            return listen(client, time, sink);
        }
        upload(client, sink)?;
        Ok(0)
    }
}

/// Records for this time; returns the number of lost samples.
fn listen(client: &mut Client, time: Duration, sink: &mut Sink) -> Result<u64, Error> {
    let mut changes = Changes::new(client);
    let has_command = add_command(&mut changes);
    let original = changes.original;
    let recorded = has_command
        .map_err(Error::from)
        .and_then(|()| receive(client, time, sink));
    // Also after an error; that of the recording comes first.
    let restored = restore(client, &original);
    let lost = recorded?;
    restored?;
    Ok(lost)
}

/// Adds the command to the telemetry for the time of the recording, in a TPDO that is not used.
fn add_command(changes: &mut Changes<'_>) -> Result<(), ClientError> {
    let telemetry = Telemetry::of(changes.client)?;
    if telemetry.position("command_deg").is_some() {
        return Ok(());
    }
    if changes.is_valid(COMMAND_TPDO)? {
        note!(
            "warning: the recording has no column command_deg: TPDO {COMMAND_TPDO} has other content"
        );
        return Ok(());
    }
    changes.map(COMMAND_TPDO, 0, &["6062"])?;
    let period_ms = 1000 / model_core::time::CONTROL_RATE_HZ;
    changes.write("1803:5", &period_ms.to_string())
}

fn receive(client: &mut Client, time: Duration, sink: &mut Sink) -> Result<u64, Error> {
    let mut clock = Clock::default();
    let mut is_first = true;
    let stop = interrupt::stop()?;
    let is_over = |now| now >= time || stop.load(Ordering::Relaxed);
    watch(client, is_over, |telemetry, now| {
        if std::mem::take(&mut is_first) {
            let names = telemetry.columns.iter().map(|column| column.name.clone());
            sink.header(names)?;
        }
        sink.row(
            seconds(&mut clock, telemetry, now),
            telemetry.values().iter().copied(),
        )
    })?;
    Ok(clock.lost)
}

/// Time by the sample counter if it is mapped, otherwise by the clock of the computer.
fn seconds(clock: &mut Clock, telemetry: &Telemetry, now: Duration) -> f64 {
    let counter = telemetry.value("sample_counter");
    counter.map_or(now.as_secs_f64(), |counter| clock.time_s(counter as u16))
}

/// The TPDO in which the command is sent, 1803h.
const COMMAND_TPDO: u8 = 4;

/// A sink for samples.
pub(super) struct Sink {
    path: PathBuf,
    out: BufWriter<Box<dyn Write>>,
    rows: u64,
    /// Names of the columns for JSON; `None` for CSV.
    keys: Option<Vec<String>>,
}

impl Sink {
    fn open(path: PathBuf, json: bool) -> Result<Self, Error> {
        let is_standard = is_standard_output(&path);
        let out: Box<dyn Write> = if is_standard {
            Box::new(io::stdout())
        } else {
            let file = File::create(&path);
            Box::new(file.map_err(|source| write_error(&path, source))?)
        };
        Ok(Self {
            path,
            out: BufWriter::new(out),
            rows: 0,
            keys: (json && is_standard).then(Vec::new),
        })
    }

    fn line(&mut self, line: &str) -> Result<(), Error> {
        let done = writeln!(self.out, "{line}");
        done.map_err(|source| self.error(source))
    }

    fn error(&self, source: io::Error) -> Error {
        write_error(&self.path, source)
    }

    pub(super) fn header(&mut self, names: impl Iterator<Item = String>) -> Result<(), Error> {
        let names: Vec<_> = names.collect();
        if let Some(keys) = &mut self.keys {
            *keys = names;
            return Ok(());
        }
        self.line(&format!("time_s,{}", names.join(",")))
    }

    /// A value that has not arrived yet is an empty field or null.
    pub(super) fn row(
        &mut self,
        time_s: f64,
        values: impl Iterator<Item = f64>,
    ) -> Result<(), Error> {
        if let Some(keys) = &self.keys {
            let named = keys.iter().cloned().zip(values.map(|value| json!(value)));
            let mut object: serde_json::Map<_, _> = named.collect();
            object.insert("time_s".into(), json!(time_s));
            self.rows += 1;
            return self.line(&serde_json::Value::Object(object).to_string());
        }
        let mut line = time_s.to_string();
        for value in values {
            line.push(',');
            if value.is_finite() {
                line += &value.to_string();
            }
        }
        self.rows += 1;
        self.line(&line)
    }

    fn close(mut self) -> Result<u64, Error> {
        let done = self.out.flush();
        done.map_err(|source| self.error(source))?;
        Ok(self.rows)
    }
}

/// Uploads the board's capture into a CSV file; how many records it has.
#[cfg(feature = "board")]
pub(crate) fn save_capture(client: &mut Client, path: &std::path::Path) -> Result<u64, Error> {
    let mut sink = Sink::open(path.to_owned(), false)?;
    upload(client, &mut sink)?;
    sink.close()
}

/// Uploads the capture of the board.
fn upload(client: &mut Client, sink: &mut Sink) -> Result<(), Error> {
    let capture = Capture::upload(client)?;
    let signals = capture.signals.iter();
    sink.header(signals.map(|signal| signal.column().to_owned()))?;
    for (number, record) in capture.records.iter().enumerate() {
        let values = record.iter().copied().map(f64::from);
        sink.row(capture.time_s(number), values)?;
    }
    Ok(())
}
