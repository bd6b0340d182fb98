//! `actuator faults`: present faults, fault history, and fault reset.

use canopen::cia402::statusword;
use clap::Args;
use serde_json::json;

use super::{AtNode, print_json};
use crate::error::Error;
use crate::output::{print, print_table};
use host_sim::can::client::state_name;
use host_sim::can::fault_history::{PastError, history, names};
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

impl Faults {
    /// Lists the faults.
    ///
    /// # Errors
    /// Those of the bus and the actuator, and for a fault that remains after a reset.
    pub fn run(&self) -> Result<(), Error> {
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
                .map(|error| json!({ "code": error.code(), "what": error.what() }))
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

fn show(
    status: u16,
    present: &[&str],
    latched: &[&str],
    history: &[PastError],
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
    for error in history {
        table.push([error.code().into(), error.what().into()]);
    }
    print_table(&table)
}
