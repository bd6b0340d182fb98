//! `actuator busload`: how many actuators a bus carries.

use clap::Args;
use serde_json::json;

use super::{bit_rate, print_json};
use crate::error::Error;
use crate::output::{print, print_table};
use host_sim::can::bus_load::{default_profile, frame_bits, share};
use host_sim::table::{Cell, Table};

/// Estimates the bus load of N actuators with their default PDOs
///
/// The least load is that of frames without stuff bits, the greatest that of frames with the most.
/// A load that may exceed 100 % is an error.
#[derive(Debug, Args)]
pub struct BusLoad {
    /// Number of actuators
    #[arg(long, value_name = "NUMBER", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=127))]
    actuators: u8,
    /// Bit rate, kbit/s
    #[arg(long, value_name = "RATE", default_value_t = 1000, value_parser = bit_rate)]
    kbit_s: u16,
    /// Rate of the two telemetry PDOs, Hz
    #[arg(long, value_name = "HZ", default_value_t = 250.0)]
    telemetry: f64,
    /// Rate of the command PDO, Hz
    #[arg(long, value_name = "HZ", default_value_t = 50.0)]
    commands: f64,
    /// Rate of the heartbeats, Hz
    #[arg(long, value_name = "HZ", default_value_t = 0.0)]
    heartbeat: f64,
    /// Prints JSON
    #[arg(long)]
    json: bool,
}

impl BusLoad {
    /// Prints the load.
    ///
    /// # Errors
    /// For a rate out of range.
    pub fn run(&self) -> Result<(), Error> {
        for (option, rate) in [
            ("--telemetry", self.telemetry),
            ("--commands", self.commands),
            ("--heartbeat", self.heartbeat),
        ] {
            if !(0.0..=1e4).contains(&rate) {
                return Err(Error::Option {
                    option,
                    value: rate.to_string(),
                    expected: "a rate of 0 to 10,000 Hz",
                });
            }
        }
        let traffic = default_profile(self.telemetry, self.commands, self.heartbeat);
        let bit_rate = f64::from(self.kbit_s) * 1e3;
        let one = share(&traffic, bit_rate);
        let number = f64::from(self.actuators);
        let (least, most) = (one.0 * number, one.1 * number);
        // A bus without traffic is limited by the number of node-IDs.
        let fit = (1.0 / one.1).floor().min(127.0) as u64;
        if self.json {
            print_json(&json!({
                "least_load": least, "greatest_load": most, "actuators_that_fit": fit, "traffic": traffic,
            }))?;
            return self.check(most, fit);
        }
        let mut table = Table::new(
            "",
            &[
                ("frame of each actuator", ""),
                ("data", "B"),
                ("rate", "Hz"),
                ("bits at most", ""),
                ("load at most", "%"),
            ],
        );
        for row in &traffic {
            let (_, bits) = frame_bits(row.bytes);
            table.push([
                row.what.into(),
                Cell::Number(row.bytes.into(), 0),
                Cell::Number(row.rate_hz, 0),
                Cell::Number(bits.into(), 0),
                Cell::Number(share(&[*row], bit_rate).1 * 100.0, 2),
            ]);
        }
        print_table(&table)?;
        print(&format!(
            "{} actuators at {} kbit/s load the bus by {:.1} % to {:.1} %; {fit} fit at the most\n",
            self.actuators,
            self.kbit_s,
            least * 100.0,
            most * 100.0,
        ))?;
        self.check(most, fit)
    }

    /// Refuses a load above 100 %.
    fn check(&self, most: f64, fit: u64) -> Result<(), Error> {
        if most <= 1.0 {
            return Ok(());
        }
        Err(Error::Conflict(format!(
            "{} actuators may load the bus by {:.1} %, expected {fit} actuators at the most, lower \
             rates or more kbit/s",
            self.actuators,
            most * 100.0
        )))
    }
}
