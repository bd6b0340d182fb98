//! Files: parameters as DCF (CiA 306) and TOML, recordings as CSV, MAT and Parquet, and the capture
//! in the board's memory.

use std::io::{self, Cursor};

use host_sim::can::capture::Capture;
use host_sim::can::client::ClientError;
use host_sim::trace_file::{Description, Format, csv::Csv, mat::Mat};
use serde::Deserialize;
use serde_json::{Value, json};

use super::Context;
use super::objects::read_everything;
use crate::parameter_file;
use crate::quantity::{self, Quantity};
use crate::record::Row;

/// Formats of parameter files.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ParameterFormat {
    /// Device configuration file of CiA 306.
    Dcf,
    /// Names and values.
    Toml,
}

/// A part of the recording of an actuator.
#[derive(Debug, Deserialize)]
pub struct Recording {
    node: u8,
    from_s: f64,
    to_s: f64,
    /// `csv`, `mat` or `parquet`.
    format: String,
}

pub fn export(context: Context, node: u8, format: ParameterFormat) {
    context.at_node(node, move |core, client| {
        let values = read_everything(client).map_err(|error| error.to_string())?;
        let number = client.node();
        let (ending, text) = match format {
            ParameterFormat::Dcf => ("dcf", parameter_file::dcf(&values, number, core.kbit_s)?),
            ParameterFormat::Toml => ("toml", parameter_file::toml(&values)?),
        };
        let name = format!("actuator-{number}.{ending}");
        Ok::<_, String>(json!({ "path": core.offer(&name, text.into_bytes()) }))
    });
}

pub fn parse(context: &Context, text: &str) {
    let values = parameter_file::parse(text);
    context
        .reply
        .result(values.map(|values| json!({ "values": values })));
}

/// Begins or ends a recording of this page; answers with the time, s.
pub fn record(context: &Context, nodes: &[u8], is_on: bool) {
    let now_s = context.core.now_s();
    for node in nodes {
        context.core.with_node(*node, |node| match is_on {
            true => node.record.keep(context.page, now_s),
            false => node.record.release(context.page),
        });
    }
    context.reply.result(Ok(json!(now_s)));
}

pub fn save_recording(context: Context, request: Recording) {
    let rows: Option<Vec<Row>> = context.core.with_node(request.node, |node| {
        let rows = node.record.rows(request.from_s, request.to_s);
        rows.copied().collect()
    });
    let reply = context.reply.clone();
    let begun = context.core.spawn(move |core, _| {
        let noun = match core.servos {
            Some(_) => "servo",
            None => "actuator",
        };
        let name = format!("{noun}-{}.{}", request.node, request.format);
        let written = match rows.as_deref() {
            None | Some([]) => Err("there are no samples in this time".to_owned()),
            Some(rows) => write(rows, &name, quantity::of(core)).map_err(|error| error.to_string()),
        };
        reply.result(written.map(|bytes| json!({ "path": core.offer(&name, bytes) })));
    });
    context.reply.busy(begun.map(drop));
}

fn values(row: &Row, quantities: &[Quantity]) -> Vec<f64> {
    // A time is a sum of periods: of its digits those of nanoseconds are true.
    let rounded = |value: f64| (value * 1e9).round() / 1e9;
    let values = row.values.iter().zip(quantities).map(|(value, quantity)| {
        // The decimal number that the sample shows, not the binary one with more digits.
        let shown = value.to_string().parse().unwrap_or(f64::NAN);
        match quantity.column_scale {
            1.0 => shown,
            scale => rounded(shown * scale),
        }
    });
    [rounded(row.time_s)].into_iter().chain(values).collect()
}

/// The content of a file with this name.
fn write(rows: &[Row], name: &str, quantities: &[Quantity]) -> io::Result<Vec<u8>> {
    let values = |row| values(row, quantities);
    let format = Format::of(name.as_ref()).map_err(io::Error::other)?;
    let description = Description {
        texts: vec![("program", format!("actuator {}", env!("CARGO_PKG_VERSION")))],
        groups: Vec::new(),
    };
    let names = quantities.iter().map(|quantity| quantity.column);
    let columns: Vec<_> = ["time_s"].into_iter().chain(names).collect();
    match format {
        Format::Csv => {
            let mut csv = Csv::create(Vec::new(), &columns)?;
            rows.iter().try_for_each(|row| csv.row(&values(row)))?;
            Ok(csv.finish())
        }
        Format::Mat => {
            let out = Cursor::new(Vec::new());
            let mut mat = Mat::create(out, &columns, rows.len() as u64, &description)?;
            rows.iter().try_for_each(|row| mat.row(&values(row)))?;
            Ok(mat.finish()?.into_inner())
        }
        #[cfg(feature = "parquet")]
        Format::Parquet => {
            use host_sim::trace_file::parquet::Parquet;
            let mut parquet = Parquet::create(Vec::new(), &columns, &description)?;
            rows.iter().try_for_each(|row| parquet.row(&values(row)))?;
            parquet.finish()
        }
        #[cfg(not(feature = "parquet"))]
        Format::Parquet => Err(io::Error::other(
            "this program was built without the feature `parquet`",
        )),
    }
}

pub fn arm_capture(context: Context, node: u8, trigger: u8, before: u16, decimation: u16) {
    context.at_node(node, move |_, client| {
        for (object, value) in [
            ("2030:3", u16::from(trigger)),
            ("2030:4", before),
            ("2030:5", decimation),
        ] {
            client.write(object, &value.to_string())?;
        }
        client.write("2030:1", "1")?;
        Ok::<_, ClientError>(json!(null))
    });
}

pub fn read_capture(context: Context, node: u8) {
    context.at_node(node, |_, client| {
        let capture = Capture::upload(client)?;
        let time: Vec<_> = (0..capture.records.len())
            .map(|i| capture.time_s(i))
            .collect();
        let column = |i: usize| -> Vec<i32> {
            let records = capture.records.iter();
            records
                .filter_map(|record| record.get(i).copied())
                .collect()
        };
        let signals = capture.signals.iter().enumerate();
        let signals: Vec<Value> = signals
            .map(|(i, signal)| json!({ "name": signal.column(), "values": column(i) }))
            .collect();
        Ok::<_, ClientError>(json!({ "time_s": time, "signals": signals }))
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::{ALL, COUNT, SERVO};

    #[test]
    fn a_recording_is_read_back_by_the_identification() {
        let rows: Vec<_> = (0..10)
            .map(|i| Row {
                time_s: f64::from(i) * 0.004,
                values: [i as f32; COUNT],
            })
            .collect();
        let text = String::from_utf8(write(&rows, "a.csv", &ALL).unwrap()).unwrap();
        let mut lines = text.lines();
        let head = lines.next().unwrap();
        assert_eq!(
            head,
            "time_s,angle_deg,command_deg,rate_deg_s,current_ma,back_emf_v,duty_pct,supply_v,temperature_degc"
        );
        assert_eq!(lines.nth(1), Some("0.004,1,1,1,1,1,1,1,1"));
        let path = tempfile::NamedTempFile::with_suffix(".csv").unwrap();
        std::fs::write(path.path(), text).unwrap();
        let import = identification::data::Import::default();
        let imported = import.read(path.path(), &mut |_, _| {}).unwrap();
        assert_eq!(imported.recording.angle_deg[3], 3.0);
        assert_eq!(imported.recording.duty_pct.unwrap()[3], 3.0);
        assert!(write(&rows, "a.mat", &ALL).unwrap().starts_with(b"MATLAB"));
        let text = String::from_utf8(write(&rows, "a.csv", &SERVO).unwrap()).unwrap();
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(
            lines[0],
            "time_s,angle_deg,command_deg,rate_deg_s,current_ma,duty_pct,supply_mv,temperature_degc"
        );
        assert_eq!(lines[2], "0.004,1,1,1,1,1,1000,1");
    }
}
