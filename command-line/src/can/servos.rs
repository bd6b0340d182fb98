//! `actuator serve --protocol`: servos on a serial bus.

use std::net::TcpListener;
use std::sync::atomic::AtomicBool;

use clap::Args;
use clap::builder::PossibleValuesParser;
use host_sim::can::server::Stream;
use host_sim::servo_bus::{self, Bus, NAMES, Server};

use crate::error::Error;
use crate::output::print;

/// Bit rate of the line: that of the STS series, and the usual one of the X series.
const BIT_S: u64 = 1_000_000;

/// Servos in place of actuators.
#[derive(Debug, Args)]
pub struct Servos {
    /// Servos of this model on a serial bus at 1 Mbit/s, with IDs from 1
    #[arg(long, value_name = "MODEL", value_parser = PossibleValuesParser::new(NAMES),
        conflicts_with_all = ["elf", "unconfigured", "seed"])]
    protocol: Option<String>,
    /// Resistance of supply and cable that the servos share, ohm
    #[arg(long, value_name = "OHM", default_value_t = 0.0, requires = "protocol")]
    supply_ohm: f64,
}

/// A bus of servos that is served.
pub struct Serving {
    server: Server,
    what: String,
}

impl Servos {
    /// Servos, if they are asked for.
    ///
    /// # Errors
    /// For a resistance that is not one, or if the system cannot wait for events.
    pub fn serve(&self, count: u8) -> Result<Option<Serving>, Error> {
        let model = self.protocol.as_deref().and_then(servo_bus::model);
        let Some(model) = model else { return Ok(None) };
        if !(0.0..=100.0).contains(&self.supply_ohm) {
            return Err(Error::Option {
                option: "--supply-ohm",
                value: self.supply_ohm.to_string(),
                expected: "0 to 100 ohm",
            });
        }
        let bus = Bus::new(&model, count, self.supply_ohm)?;
        let ids = match count {
            1 => "1 servo with ID 1".to_owned(),
            most => format!("{most} servos with IDs 1 to {most}"),
        };
        let name = model.table.name;
        let server = Server::new(bus, BIT_S).map_err(|source| failed(name, source))?;
        let what = format!("{ids} of the model {name}");
        Ok(Some(Serving { server, what }))
    }
}

impl Serving {
    /// Adds a client.
    ///
    /// # Errors
    /// If the system cannot wait for its events.
    pub fn add(&mut self, stream: impl Stream + 'static, address: &str) -> Result<(), Error> {
        let added = self.server.add(stream);
        added.map_err(|source| failed(address, source))
    }

    /// Runs the servos until an interrupt.
    ///
    /// # Errors
    /// If the system cannot wait for events.
    pub fn run(
        self,
        listener: Option<TcpListener>,
        address: &str,
        stop: &AtomicBool,
    ) -> Result<(), Error> {
        print(&format!("ready: serial bus at {address}, {}\n", self.what))?;
        let done = self.server.run(listener, stop);
        done.map_err(|source| failed(address, source))
    }
}

fn failed(address: &str, source: std::io::Error) -> Error {
    Error::Serve {
        address: address.into(),
        source,
    }
}
