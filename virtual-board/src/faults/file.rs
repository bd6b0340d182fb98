//! Reads the text of a fault plan.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use super::{Fault, Planned, Trigger};

/// Error of a fault plan.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// It is not TOML, or has an unknown field.
    #[error("{path}: {message}", path = path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, column, and the expected input.
        message: String,
    },
    /// An entry is inconsistent.
    #[error("{path}:{line}: {message}", path = path.display())]
    Senseless {
        /// The file.
        path: PathBuf,
        /// The line of the entry.
        line: usize,
        /// The error.
        message: String,
    },
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    fault: Vec<Spanned<Entry>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    at_ms: Option<f64>,
    at_instruction: Option<u64>,
    at_symbol: Option<String>,
    hit: Option<u64>,
    for_ms: Option<f64>,
    what: Fault,
}

/// Maximum time in a plan, ms: a week.
const LONGEST_MS: f64 = 7.0 * 86_400e3;

fn nanoseconds(name: &str, ms: f64) -> Result<u64, String> {
    if !(0.0..=LONGEST_MS).contains(&ms) {
        return Err(format!("{name} is {ms}, expected 0 to {LONGEST_MS}"));
    }
    Ok((ms * 1e6).round() as u64)
}

impl Entry {
    fn trigger(&self) -> Result<Trigger, String> {
        let given = (self.at_ms, self.at_instruction, &self.at_symbol);
        let trigger = match given {
            (Some(ms), None, None) => Trigger::At {
                ns: nanoseconds("at_ms", ms)?,
            },
            (None, Some(count), None) => Trigger::Instruction { count },
            (None, None, Some(name)) => Trigger::Symbol {
                name: name.clone(),
                hit: self.hit.unwrap_or(1).max(1),
            },
            _ => return Err("expected exactly one of at_ms, at_instruction, at_symbol".into()),
        };
        if self.hit.is_some() && !matches!(trigger, Trigger::Symbol { .. }) {
            return Err("hit goes with at_symbol alone".into());
        }
        Ok(trigger)
    }

    fn planned(&self) -> Result<Planned, String> {
        if let Some((name, value, least, most)) = self.what.bounds()
            && !(least..=most).contains(&value)
        {
            return Err(format!("{name} is {value}, expected {least} to {most}"));
        }
        let for_ns = self
            .for_ms
            .map(|ms| nanoseconds("for_ms", ms))
            .transpose()?;
        Ok(Planned {
            trigger: self.trigger()?,
            for_ns,
            fault: self.what.clone(),
        })
    }
}

/// The fault plan of a text that has been read from this file.
///
/// # Errors
/// Gives the file, and the line of an inconsistent entry.
pub fn parse_plan(path: &Path, text: &str) -> Result<Vec<Planned>, PlanError> {
    let file: File = toml::from_str(text).map_err(|error| PlanError::Malformed {
        path: path.into(),
        message: error.to_string(),
    })?;
    let planned = |entry: &Spanned<Entry>| {
        let before = text.get(..entry.span().start).unwrap_or_default();
        entry
            .get_ref()
            .planned()
            .map_err(|message| PlanError::Senseless {
                path: path.into(),
                line: 1 + before.matches('\n').count(),
                message,
            })
    };
    file.fault.iter().map(planned).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{FilterBit, MagnetState, MemoryLocation};
    use super::*;
    use crate::can::WireFault;
    use crate::plant::{EncoderWire, Stuck};

    fn read(text: &str) -> Result<Vec<Planned>, String> {
        parse_plan(Path::new("plan.toml"), text).map_err(|error| error.to_string())
    }

    fn faults(whats: &[&str]) -> Vec<Fault> {
        let entry = |what: &&str| format!("[[fault]]\nat_ms = 1\nwhat = {what}\n");
        let text: String = whats.iter().map(entry).collect();
        read(&text).unwrap().into_iter().map(|p| p.fault).collect()
    }

    #[test]
    fn every_kind_can_be_written() {
        let read = faults(&[
            "{ encoder_wire = { line = \"clock\", stuck = \"high\" } }",
            "{ magnet = { state = \"lost\" } }",
            "\"jam\"",
            "{ flip_ram = { symbol = \"STATE\", bit = 5 } }",
            "{ flip_ram = { address = 0x20000010, bit = 5 } }",
            "{ can = { wire = \"short\" } }",
            "{ servo_pulse = {} }",
            "{ acceptance_filter = { activation = 3 } }",
        ]);
        let expected = [
            Fault::EncoderWire {
                line: EncoderWire::Clock,
                stuck: Stuck::High,
            },
            Fault::Magnet {
                state: MagnetState::Lost,
            },
            Fault::Jam,
            Fault::FlipRam {
                place: MemoryLocation::Symbol("STATE".into()),
                bit: 5,
            },
            Fault::FlipRam {
                place: MemoryLocation::Address(0x2000_0010),
                bit: 5,
            },
            Fault::Can {
                wire: WireFault::Short,
            },
            Fault::ServoPulse { us: None },
            Fault::AcceptanceFilter(FilterBit::Activation(3)),
        ];
        assert_eq!(read, expected);
    }

    #[test]
    fn times_counts_and_symbols_trigger() {
        let plan = read(
            "[[fault]]\nat_ms = 1.5\nfor_ms = 2\nwhat = \"jam\"\n\
             [[fault]]\nat_instruction = 7\nwhat = \"jam\"\n\
             [[fault]]\nat_symbol = \"step\"\nhit = 3\nwhat = \"jam\"\n",
        );
        let plan = plan.unwrap();
        assert_eq!(plan[0].trigger, Trigger::At { ns: 1_500_000 });
        assert_eq!(plan[0].for_ns, Some(2_000_000));
        assert_eq!(plan[1].trigger, Trigger::Instruction { count: 7 });
        let name = "step".to_owned();
        assert_eq!(plan[2].trigger, Trigger::Symbol { name, hit: 3 });
    }

    #[test]
    fn errors_name_file_and_line() {
        let error = |text: &str| read(text).unwrap_err();
        let two = "[[fault]]\nat_ms = 1\nwhat = \"jam\"\n\n[[fault]]\n";
        let message = error(&format!("{two}what = \"jam\"\n"));
        assert!(
            message.starts_with("plan.toml:5: expected exactly one of"),
            "{message}"
        );
        let message = error(&format!("{two}at_ms = -1\nwhat = \"jam\"\n"));
        assert!(message.contains("plan.toml:5: at_ms is -1"), "{message}");
        let message = error(&format!(
            "{two}at_ms = 1\nwhat = {{ supply = {{ volts = 99 }} }}\n"
        ));
        assert!(
            message.contains("volts is 99, expected 0 to 60"),
            "{message}"
        );
        let message = error(&format!("{two}at_ms = 1\nwhat = \"jamm\"\n"));
        assert!(
            message.contains("line 7") && message.contains("jamm"),
            "{message}"
        );
        let message = error("[[fault]]\nat_mss = 1\nwhat = \"jam\"\n");
        assert!(
            message.contains("line 2") && message.contains("at_mss"),
            "{message}"
        );
    }
}
