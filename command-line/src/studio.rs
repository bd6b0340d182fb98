//! `actuator studio`: a page in a browser that shows, moves, tunes and identifies actuators.

use std::io::{self, Write as _};
use std::net::SocketAddr;
use std::process::{Command, Stdio};

use clap::Args;

use crate::can::bit_rate;
use crate::error::Error;
use crate::interrupt;
use crate::output::print;
use studio::{NativeBus, Notice, Options};

/// Opens a page that shows, moves, tunes and identifies the actuators of a bus
///
/// Without --bus it simulates two actuators, so that no hardware is needed. The address that it
/// prints contains a token, which permits to command the actuators. An interrupt ends it, stops
/// the drives, and leaves the actuators as they were. Servos hold the angle that they have.
#[derive(Debug, Args)]
pub struct Studio {
    /// HOST:PORT for slcan over TCP, a serial device (/dev/ttyACM0, COM3), a SocketCAN interface
    /// (can0), or servos: sts:/dev/ttyUSB0 of Feetech, dxl:/dev/ttyUSB0@57600 of Robotis, at
    /// 1,000,000 bit/s unless another rate follows, sts:HOST:PORT [default: simulated actuators]
    #[arg(long, value_name = "BUS")]
    bus: Option<String>,
    /// Bit rate of the adapter, kbit/s
    #[arg(long, value_name = "RATE", default_value_t = 1000, value_parser = bit_rate)]
    kbit_s: u16,
    /// Number of simulated actuators
    #[arg(long, value_name = "NUMBER", default_value_t = 2, conflicts_with = "bus",
        value_parser = clap::value_parser!(u8).range(1..=126))]
    nodes: u8,
    /// Address and port of the page; a port that is taken is replaced by a free one
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:29500")]
    listen: SocketAddr,
    /// Does not open a browser
    #[arg(long)]
    no_open: bool,
}

/// Opens Studio with simulated actuators and a tour in three minutes
///
/// The tour moves an actuator, breaks its encoder, identifies and tunes it. An interrupt ends it.
#[derive(Debug, Args)]
pub struct Demo {
    /// Address and port of the page; a port that is taken is replaced by a free one
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:29500")]
    listen: SocketAddr,
    /// Does not open a browser
    #[arg(long)]
    no_open: bool,
}

impl Demo {
    /// Serves until an interrupt.
    ///
    /// # Errors
    /// For an address that is not available.
    pub fn run(self) -> Result<(), Error> {
        let studio = Studio {
            bus: None,
            kbit_s: 1000,
            nodes: 2,
            listen: self.listen,
            no_open: self.no_open,
        };
        studio.serve("#tour")
    }
}

/// Writes to standard error; a closed reader is ignored.
fn report(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

impl Studio {
    /// Serves until an interrupt.
    ///
    /// # Errors
    /// For a bus that cannot be opened, and an address that is not available.
    pub fn run(self) -> Result<(), Error> {
        self.serve("")
    }

    /// Serves; the address of the page ends with this.
    fn serve(self, view: &str) -> Result<(), Error> {
        let stop = interrupt::stop()?;
        let native = match &self.bus {
            Some(_) => None,
            None => Some(NativeBus::start(self.nodes, report)?),
        };
        let simulated = native.as_ref().map(|native| native.address().to_string());
        let options = Options {
            listen: self.listen,
            bus_name: match &self.bus {
                Some(bus) => bus.clone(),
                None if self.nodes == 1 => "1 simulated actuator".into(),
                None => format!("{} simulated actuators", self.nodes),
            },
            bus: simulated.clone().or(self.bus).unwrap_or_default(),
            kbit_s: self.kbit_s,
            encoder_switches: (native.as_ref())
                .map(NativeBus::encoder_switches)
                .unwrap_or_default(),
        };
        let studio = studio::Studio::open(options, report)?;
        let address = studio.address();
        if !address.ip().is_loopback() {
            report(&format!(
                "warning: {address} can be reached from other computers; the connection is not \
                 encrypted, and the token in it permits to command the actuators"
            ));
        }
        if let Some(simulated) = simulated {
            report(&format!(
                "the simulated actuators are at --bus {simulated} for other commands"
            ));
        }
        let url = studio.url() + view;
        print(&format!("ready: {url}\n"))?;
        if !self.no_open {
            open_browser(&url);
        }
        let run = studio.run(&stop, &mut |notice: &Notice| report(&notice.to_string()));
        run.map_err(|source| Error::Serve {
            address: address.to_string(),
            source,
        })
    }
}

/// Opens the address in the user's browser.
fn open_browser(url: &str) {
    let (program, arguments): (&str, &[&str]) = if cfg!(target_os = "macos") {
        ("open", &[])
    } else if cfg!(windows) {
        ("rundll32", &["url.dll,FileProtocolHandler"])
    } else {
        ("xdg-open", &[])
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(url);
    command.stdin(Stdio::null()).stdout(Stdio::null());
    if command.stderr(Stdio::null()).spawn().is_err() {
        report("no browser could be opened; open the address yourself");
    }
}
