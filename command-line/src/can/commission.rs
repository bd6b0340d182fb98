//! `actuator commission`: checks, measures, writes and saves.

use std::fmt::Write as _;

use clap::Args;
use serde_json::json;

use super::move_to::mdeg;
use super::{AtNode, print_json};
use crate::error::Error;
use crate::interrupt;
use crate::output::print;
use host_sim::can::client::Client;
use host_sim::commission::{self, CommissionError, Findings, Kept, Limits};

/// Checks the wiring of an actuator, measures its torque constant, and saves it with the range
///
/// The shaft moves for less than half a minute. Pulses of growing torque show the senses of motor,
/// encoder and current; runs at constant rate in both directions within --range give the torque
/// constant by the gear ratio of 2011h:3. What is wrong or cannot be identified is refused with
/// exit status 3, and nothing is written; otherwise 607Dh and 2011h:2 are written, and all
/// parameters are saved (1010h).
#[derive(Debug, Args)]
pub struct Commission {
    /// Range of the angle, deg
    #[arg(long, num_args = 2, value_names = ["MIN", "MAX"], required = true)]
    range: Vec<f64>,
    /// Highest current of the pulses, % of the rated current 6075h
    #[arg(long, value_name = "PERCENT", default_value_t = 100, value_parser = clap::value_parser!(u16).range(1..=200))]
    current: u16,
    /// Highest rate, deg/s
    #[arg(long, value_name = "DEG_S", default_value_t = 120, value_parser = clap::value_parser!(u16).range(40..=2000))]
    rate: u16,
    /// Writes and saves nothing
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    at: AtNode,
}

impl Commission {
    /// Commissions the actuator.
    ///
    /// # Errors
    /// For an invalid number, the refusals of the steps; those of the bus and the actuator.
    pub fn run(&self) -> Result<(), Error> {
        let limits = self.limits()?;
        let mut client = self.at.open()?;
        let measure = |client: &mut Client| commission::measure(client, &limits);
        let kept = Kept::of(&mut client)?;
        let findings = client.supervised(interrupt::stop()?, measure, Client::quick_stop);
        let restored = kept.restore(&mut client);
        // The error of the motion is more informative than that behind it.
        let findings = findings?;
        restored?;
        if !self.dry_run {
            commission::write(&mut client, &limits, &findings)?;
        }
        match self.at.json() {
            true => print_json(&json!({ "saved": !self.dry_run, "findings": findings })),
            false => print(&table(&findings, self.dry_run)),
        }
    }

    fn limits(&self) -> Result<Limits, Error> {
        let (low, high) = match self.range[..] {
            [low, high] => (mdeg("--range", low)?, mdeg("--range", high)?),
            _ => (0, 0),
        };
        // A pulse needs 15 deg on both sides, and a run room for its settling.
        // Two turns are reached in the time of a run.
        let width = i64::from(high) - i64::from(low);
        if !(40_000..=720_000).contains(&width) {
            let text = format!(
                "--range is {low} to {high} mdeg, expected 40 to 720 deg from MIN up to MAX"
            );
            return Err(Error::Conflict(text));
        }
        Ok(Limits {
            range_mdeg: (low, high),
            permille: self.current * 10,
            rate_mdeg_s: i32::from(self.rate) * 1000,
        })
    }
}

/// A line for each value; what is identified has its standard error.
fn table(findings: &Findings, is_dry: bool) -> String {
    let mut text = String::new();
    let estimate = findings.torque_constant_nm_a;
    let (value, error) = (estimate.value, estimate.standard_error);
    let _ = writeln!(
        text,
        "{:<28}{value:.6} +- {error:.6}",
        "torque constant, Nm/A"
    );
    let supply = findings.least_supply_v;
    let _ = writeln!(text, "{:<28}{supply:.2}", "lowest supply, V");
    let _ = writeln!(
        text,
        "{:<28}{:.1}",
        "board, deg C", findings.temperature_deg_c
    );
    text += match is_dry {
        true => "not written: --dry-run\n",
        false => "written and saved\n",
    };
    text
}

impl From<CommissionError> for Error {
    fn from(error: CommissionError) -> Self {
        match error {
            CommissionError::Client(error) => Self::Bus(error),
            refused => Self::Refused(refused.to_string()),
        }
    }
}
