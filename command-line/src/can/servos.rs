//! `actuator serve --protocol`: servos on a serial bus.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;

use clap::Args;
use clap::builder::PossibleValuesParser;
#[cfg(unix)]
use host_sim::can::server::Terminal;
use host_sim::servo_bus::{self, Bus, Fault, NAMES, Server};
use model_core::parameter::Shown;

use super::loads::Loads;
use crate::error::Error;
use crate::output::print;

/// Bit rate of the line: that of the STS series, and the usual one of the X series.
const BIT_S: u64 = 1_000_000;

/// The protocol of actuators, in place of CANopen.
const DRONECAN: &str = "dronecan";

/// The most boards that a bus has: those of an arm.
const MOST_BOARDS: u8 = 6;

/// Servos in place of actuators.
#[derive(Debug, Args)]
pub struct Servos {
    /// DroneCAN on the CAN bus, with actuator-IDs from 1; or servos of a model on a serial bus at
    /// 1 Mbit/s, with IDs from 1
    ///
    /// The servos are simulated. With --elf, they are up to six emulated actuator boards, without a
    /// communication board.
    #[arg(long, value_name = "PROTOCOL", conflicts_with = "unconfigured",
        value_parser = PossibleValuesParser::new(NAMES.into_iter().chain([DRONECAN])))]
    protocol: Option<String>,
    /// Resistance of supply and cable that the servos share, ohm
    #[arg(long, value_name = "OHM", default_value_t = 0.0, requires = "protocol")]
    supply_ohm: f64,
    /// Faults as they are written to this file or pipe, one a line; `-` for standard input
    ///
    /// `supply 5.5` sets the voltage; the number of a servo and `jam`, `free`, `load NM`, `vanish`,
    /// `return`, `corrupt ANSWERS` or `id ID` concern that servo. An emulated board takes `supply`,
    /// `jam`, `free` and `load`.
    #[arg(long, value_name = "FILE", requires = "protocol")]
    servo_faults: Option<PathBuf>,
}

/// A bus of servos that is served.
pub struct Serving {
    server: Server,
    what: String,
    faults: Receiver<Fault>,
}

impl Servos {
    /// Whether the actuators have DroneCAN.
    pub fn is_dronecan(&self) -> bool {
        self.protocol.as_deref() == Some(DRONECAN)
    }

    /// Whether there are servos on a serial bus, and no actuators.
    pub fn is_serial(&self) -> bool {
        self.protocol.is_some() && !self.is_dronecan()
    }

    /// Servos with these loads, if they are asked for.
    ///
    /// # Errors
    /// For a resistance that is not one, or if the system cannot wait for events.
    pub fn serve(&self, count: u8, loads: &Loads) -> Result<Option<Serving>, Error> {
        let model = self.protocol.as_deref().and_then(servo_bus::model);
        let Some(model) = model else { return Ok(None) };
        if !(0.0..=100.0).contains(&self.supply_ohm) {
            return Err(Error::Option {
                option: "--supply-ohm",
                value: Shown(self.supply_ohm).to_string(),
                expected: "0 to 100 ohm",
            });
        }
        let bus = Bus::with_loads(&model, count, |id| loads.of(id), self.supply_ohm)?;
        let name = model.table.name;
        let server = Server::new(bus, BIT_S).map_err(|source| failed(name, source))?;
        Ok(Some(Serving {
            server,
            what: what(name, count),
            faults: self.faults(count, |_| true),
        }))
    }

    /// The faults as they come, of so many servos which have those that are not filtered out.
    fn faults(&self, count: u8, has: impl Fn(&Fault) -> bool + Send + 'static) -> Receiver<Fault> {
        let (sender, faults) = mpsc::channel();
        if let Some(path) = self.servo_faults.clone() {
            let refused = move |fault: &Fault| match fault {
                Fault::Of(servo, _) if *servo > usize::from(count) => {
                    Some(format!("the bus has {count} servos"))
                }
                _ if !has(fault) => Some("an emulated board has no such fault".to_owned()),
                _ => None,
            };
            thread::spawn(move || read_faults(&path, refused, &sender));
        }
        faults
    }

    /// Whether so many emulated boards can be these servos.
    ///
    /// # Errors
    /// For more boards than run in real time, and a property of simulated servos.
    pub fn check_boards(&self, count: u8) -> Result<(), Error> {
        if count > MOST_BOARDS {
            return Err(Error::Option {
                option: "--nodes",
                value: count.to_string(),
                expected: "1 to 6 emulated boards on a serial bus",
            });
        }
        if self.supply_ohm != 0.0 {
            return Err(Error::Conflict(
                "--supply-ohm concerns simulated servos, and boards (--elf) have supplies of their own"
                    .into(),
            ));
        }
        Ok(())
    }
}

/// What is on a bus.
fn what(model: &str, count: u8) -> String {
    let ids = match count {
        1 => "1 servo with ID 1".to_owned(),
        most => format!("{most} servos with IDs 1 to {most}"),
    };
    format!("{ids} of the model {model}")
}

/// The line that reports that a bus is served.
fn ready_line(address: &str, what: &str) -> String {
    format!("ready: serial bus at {address}, {what}\n")
}

#[cfg(feature = "board")]
impl Servos {
    /// The protocol that the parameters of the boards select.
    pub fn interface(&self) -> crate::emulated::Interface {
        use crate::emulated::Interface;
        use firmware::drive::ServoModel;
        let Some(protocol) = self.protocol.as_deref() else {
            return Interface::CanOpen;
        };
        let mut models = ServoModel::ALL.into_iter();
        match models.find(|model| model.table().name == protocol) {
            Some(model) => Interface::ServoBus(model),
            None => Interface::DroneCan,
        }
    }

    /// The line that reports that so many boards are served.
    pub fn boards_line(&self, address: &str, count: u8) -> String {
        let model = self.protocol.as_deref().unwrap_or_default();
        ready_line(address, &what(model, count))
    }

    /// The faults of so many boards, as they come.
    pub fn board_faults(&self, count: u8) -> Receiver<Fault> {
        let boards = usize::from(count);
        let has = move |fault: &Fault| !crate::emulated::on_boards(*fault, boards).is_empty();
        self.faults(count, has)
    }
}

impl Serving {
    /// With this terminal as a client.
    ///
    /// # Errors
    /// If the system cannot wait for its events.
    #[cfg(unix)]
    pub fn with(mut self, terminal: Terminal, address: &str) -> Result<Self, Error> {
        let added = self.server.add(terminal);
        added.map_err(|source| failed(address, source))?;
        Ok(self)
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
        print(&ready_line(address, &self.what))?;
        let done = self.server.run(listener, &self.faults, stop);
        done.map_err(|source| failed(address, source))
    }
}

/// Sends the faults of a file until its end, and reports each line that is not a fault, or one of
/// which `refused` has a reason. A pipe does not end with its writer: it is open for writing here
/// too.
pub(super) fn read_faults<F: Copy + FromStr<Err: Display>>(
    path: &Path,
    refused: impl Fn(&F) -> Option<String>,
    to: &Sender<F>,
) {
    let file: io::Result<Box<dyn io::Read>> = if path == Path::new("-") {
        Ok(Box::new(io::stdin()))
    } else {
        let opened = File::options().read(true).write(is_pipe(path)).open(path);
        opened.map(|file| Box::new(file) as _)
    };
    let lines = match file {
        Ok(file) => BufReader::new(file).lines(),
        Err(error) => return note!("cannot read {}: {error}", path.display()),
    };
    for line in lines.map_while(Result::ok) {
        match line.parse().map(|fault| (refused(&fault), fault)) {
            Ok((Some(why), _)) => note!("fault `{line}`: {why}"),
            // The server ends.
            Ok((None, fault)) if to.send(fault).is_err() => return,
            Ok(_) => {}
            Err(error) => note!("{error}"),
        }
    }
}

#[cfg(unix)]
fn is_pipe(path: &Path) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    path.metadata().is_ok_and(|it| it.file_type().is_fifo())
}

#[cfg(not(unix))]
fn is_pipe(_: &Path) -> bool {
    false
}

fn failed(address: &str, source: io::Error) -> Error {
    Error::Serve {
        address: address.into(),
        source,
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::{fs, time::Duration};

    use super::*;

    #[test]
    fn a_pipe_takes_the_faults_of_one_writer_after_another() {
        let folder = tempfile::tempdir().expect("a folder");
        let pipe = folder.path().join("faults");
        let mode = rustix::fs::Mode::from_raw_mode(0o600);
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0)
            .expect("a pipe");
        let (sender, faults) = mpsc::channel::<u8>();
        let path = pipe.clone();
        let refused = |number: &u8| (*number > 100).then(|| "too large".to_owned());
        thread::spawn(move || read_faults(&path, refused, &sender));
        for (written, fault) in [("1\n", 1), ("no number\n200\n2\n", 2), ("3\n", 3)] {
            let pipe = pipe.clone();
            // It would wait for a reader.
            thread::spawn(move || fs::write(&pipe, written));
            let taken = faults.recv_timeout(Duration::from_secs(10));
            assert_eq!(taken.expect("a fault"), fault);
            // Time in which a reader would find the end of a pipe without a writer.
            thread::sleep(Duration::from_millis(50));
        }
    }
}
