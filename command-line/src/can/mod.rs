//! Commands that serve a bus of actuators, or access one.

mod boards;
mod bus_load;
mod commission;
mod dronecan;
mod excite;
mod faults;
mod loads;
mod monitor;
mod move_to;
mod objects;
pub(crate) mod record;
mod scan;
mod serve;
mod service;
mod servo;
mod servos;
mod stop;
mod telemetry;
mod update;

use std::time::Duration;

use canopen::slcan::KBIT_S;
use clap::Args;

pub use bus_load::BusLoad;
pub use commission::Commission;
pub use excite::Excite;
pub use faults::Faults;
pub use monitor::Monitor;
pub use move_to::Move;
pub use objects::{Get, Restore, Save, Set};
pub use record::Record;
pub use scan::Scan;
pub use serve::Serve;
pub use stop::Stop;
pub use update::Update;

use crate::error::Error;
use host_sim::can::client::Client;
use host_sim::{dronecan_client, servo_bus};
use model_core::parameter::Shown;

/// The bus.
#[derive(Debug, Args)]
pub(super) struct OnBus {
    /// HOST:PORT for slcan over TCP, a serial device (/dev/ttyACM0, COM3), or a SocketCAN interface
    /// (can0); `scan`, `get`, `set`, `move`, `stop`, `monitor` and `record` take servos too:
    /// sts:/dev/ttyUSB0 of Feetech, dxl:/dev/ttyUSB0@57600 of Robotis, at 1,000,000 bit/s unless
    /// another rate follows; `scan`, `get`, `set`, `monitor`, `move` and `stop` take DroneCAN
    /// nodes: dronecan:can0
    #[arg(long, value_name = "BUS", default_value = "127.0.0.1:29536")]
    bus: String,
    /// Bit rate of the adapter, kbit/s
    #[arg(long, value_name = "RATE", default_value_t = 1000, value_parser = bit_rate)]
    kbit_s: u16,
    /// Prints JSON
    #[arg(long)]
    json: bool,
}

impl OnBus {
    fn open(&self, node: u8) -> Result<Client, Error> {
        if servo_bus::client::is_servo_bus(&self.bus) {
            let text = "servos have the commands scan, get, set, move, stop, monitor and record";
            return Err(Error::Conflict(text.into()));
        }
        if dronecan_client::is_dronecan(&self.bus) {
            let text = "DroneCAN has the commands scan, get, set, monitor, move and stop";
            return Err(Error::Conflict(text.into()));
        }
        Ok(Client::open(&self.bus, self.kbit_s, node)?)
    }

    /// The bus with DroneCAN, if it is one.
    fn dronecan(&self) -> Result<Option<dronecan_client::Client>, Error> {
        let is_one = dronecan_client::is_dronecan(&self.bus);
        let client = is_one.then(|| dronecan_client::Client::open(&self.bus, self.kbit_s));
        Ok(client.transpose()?)
    }

    /// The serial bus, if it is one.
    fn servos(&self) -> Result<Option<servo_bus::client::Client>, Error> {
        let is_one = servo_bus::client::is_servo_bus(&self.bus);
        let client = is_one.then(|| servo_bus::client::Client::open(&self.bus));
        Ok(client.transpose()?)
    }
}

/// One actuator on a bus.
#[derive(Debug, Args)]
pub(super) struct AtNode {
    #[command(flatten)]
    bus: OnBus,
    /// Node-ID of the actuator
    #[arg(long, short, value_name = "ID", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=127))]
    node: u8,
}

impl AtNode {
    fn open(&self) -> Result<Client, Error> {
        self.bus.open(self.node)
    }

    /// The servo, if the bus is a serial one.
    fn servo(&self) -> Result<Option<servo::Servo>, Error> {
        let client = self.bus.servos()?;
        client
            .map(|client| servo::Servo::find(client, self.node))
            .transpose()
    }

    /// The node, if the bus has DroneCAN.
    fn drone(&self) -> Result<Option<dronecan::Node>, Error> {
        let client = self.bus.dronecan()?;
        Ok(client.map(|client| dronecan::Node::new(client, self.node)))
    }

    fn json(&self) -> bool {
        self.bus.json
    }
}

/// Prints a value as JSON, on one line.
fn print_json(value: &serde_json::Value) -> Result<(), Error> {
    super::output::print(&format!("{value}\n"))
}

/// A bit rate of slcan adapters, kbit/s.
pub(crate) fn bit_rate(text: &str) -> Result<u16, String> {
    let rate = text.parse().ok().filter(|rate| KBIT_S.contains(rate));
    rate.ok_or_else(|| {
        let known = KBIT_S.map(|rate| rate.to_string()).join(", ");
        format!("expected one of {known} kbit/s")
    })
}

/// A positive time of an option.
fn length(option: &'static str, seconds: f64) -> Result<Duration, Error> {
    let time = Duration::try_from_secs_f64(seconds).ok();
    let time = time.filter(|time| !time.is_zero());
    time.ok_or_else(|| Error::Option {
        option,
        value: Shown(seconds).to_string(),
        expected: "a time above 0 s",
    })
}
