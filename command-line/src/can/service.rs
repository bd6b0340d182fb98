//! The option `--password` of the commands that a service password may lock.

use clap::Args;
use host_sim::can::{client::Client, service};

use crate::error::Error;

/// Access to what the service password locks.
#[derive(Debug, Args)]
pub(super) struct ServiceAccess {
    /// Service password of the actuator (object 2103h), decimal or after 0x hexadecimal; the
    /// actuator is locked again afterwards
    #[arg(long, value_name = "NUMBER", value_parser = password)]
    password: Option<u32>,
}

impl ServiceAccess {
    /// Does something with the access, and takes it back also if that fails.
    pub fn during<T>(
        &self,
        client: &mut Client,
        work: impl FnOnce(&mut Client) -> Result<T, Error>,
    ) -> Result<T, Error> {
        if let Some(password) = self.password {
            service::open(client, password)?;
        }
        let done = work(client);
        match (&done, self.password) {
            (Ok(_), Some(_)) => service::lock(client)?,
            (Err(_), Some(_)) => {
                // The error of the work is the one to be shown.
                let _ = service::lock(client);
            }
            (Err(error), None) if error.is_refusal() => {
                if let Some(missing) = service::missing(client) {
                    return Err(missing.into());
                }
            }
            (_, None) => {}
        }
        done
    }
}

fn password(text: &str) -> Result<u32, String> {
    let number = match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    };
    let number = number.filter(|number| *number != 0);
    number.ok_or_else(|| "expected a number from 1 to 4294967295, or 0x1 to 0xFFFFFFFF".into())
}
