//! `actuator faults`: present faults, fault history, and fault reset.

use canopen::cia402::statusword;
use clap::Args;
use firmware::faults::{Fault, TABLE};
use serde_json::json;

use super::{AtNode, print_json};
use crate::error::Error;
use crate::output::{print, print_table};
use host_sim::can::client::{Client, state_name};
use host_sim::table::Table;

/// Lists the faults of an actuator: present, latched, and the last eight errors.
#[derive(Debug, Args)]
pub struct Faults {
    /// Resets latched faults that are no longer present
    #[arg(long)]
    reset: bool,
    /// Clears the history
    #[arg(long)]
    clear: bool,
    #[command(flatten)]
    at: AtNode,
}

/// The faults whose bits are set.
fn names(bits: i64) -> Vec<&'static str> {
    let named = TABLE
        .iter()
        .filter(|row| bits >> row.fault.number() & 1 == 1);
    named.map(|row| row.name).collect()
}

impl Faults {
    /// Lists the faults.
    ///
    /// # Errors
    /// Those of the bus and the actuator, and for a fault that remains after a reset.
    pub fn run(self) -> Result<(), Error> {
        self.faults()
    }

    fn faults(&self) -> Result<(), Error> {
        let mut client = self.at.open()?;
        if self.clear {
            client.write("1003:0", "0")?;
        }
        // A drive without a fault stays enabled.
        if self.reset && client.status()? & statusword::FAULT != 0 {
            client.reset_fault()?;
        }
        let status = client.status()?;
        let present = names(client.integer("2050:9")?);
        let latched = names(client.integer("2050:10")?);
        let history = history(&mut client)?;
        if self.at.json() {
            let history: Vec<_> = history
                .iter()
                .map(|(code, what)| json!({ "code": code, "what": what }))
                .collect();
            print_json(&json!({
                "state": state_name(status), "present": present, "latched": latched, "history": history,
            }))?;
        } else {
            show(status, &present, &latched, &history)?;
        }
        if self.reset && !latched.is_empty() {
            return Ok(client.fail_in_state("expected the reset to clear every fault")?);
        }
        Ok(())
    }
}

/// Error codes with their causes, the newest first.
fn history(client: &mut Client) -> Result<Vec<(String, String)>, Error> {
    let mut history = Vec::new();
    for sub in 1..=client.integer("1003:0")? {
        let word = client.integer(&format!("1003:{sub}"))?;
        let (code, instance) = (word & 0xFFFF, (word >> 16) as u16 & 0xFF);
        // Below 128 the instance is a node or a PDO.
        let number = instance.saturating_sub(128);
        let fault = Fault::of_number(number).and_then(|fault| {
            let rows = TABLE.iter();
            rows.filter(|row| i64::from(row.error_code) == code)
                .find(|row| row.fault == fault)
        });
        let what = fault.map_or_else(
            || format!("of the bus, {instance}"),
            |row| row.name.to_owned(),
        );
        history.push((format!("{code:04X}h"), what));
    }
    Ok(history)
}

fn show(
    status: u16,
    present: &[&str],
    latched: &[&str],
    history: &[(String, String)],
) -> Result<(), Error> {
    let list = |names: &[&str]| {
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        }
    };
    print(&format!(
        "state:   {}\npresent: {}\nlatched: {}\n",
        state_name(status),
        list(present),
        list(latched)
    ))?;
    if history.is_empty() {
        return Ok(());
    }
    let mut table = Table::new("", &[("error code", ""), ("what", "")]);
    for (code, what) in history {
        table.push([code.clone().into(), what.clone().into()]);
    }
    print_table(&table)
}
