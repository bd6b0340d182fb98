//! `actuator serve`: actuators on a virtual bus.

use std::io::{self, Write as _};
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{self, Receiver};
use std::thread;

use canopen::NodeId;
use clap::Args;
use model_core::plant::board::BoardPlantOptions;

use super::boards::Boards;
use super::loads::Loads;
use super::servos::{Servos, read_faults};
use crate::error::Error;
use crate::interrupt;
use crate::output::print;
#[cfg(unix)]
use crate::terminal;
use host_sim::can::bus::Bus;
use host_sim::can::multicast;
use host_sim::can::native_node::{CAPTURE_VALUES, NativeNode};
use host_sim::can::node_fault::Fault;
#[cfg(unix)]
use host_sim::can::server::Terminal;
use host_sim::can::server::{Notice, Server};

/// Runs actuators on a virtual CAN bus in real time, and provides the bus as slcan
///
/// Up to 64 clients can connect. One that sends more frames than the bus carries is delayed; one
/// that does not read loses lines, which its status `F` reports. A line on standard output reports
/// that the server is ready, lines on standard error report such clients; an interrupt ends it.
///
/// With ELF files the programs run on emulated boards instead, and the server provides the serial
/// line of the communication board, which has one client at a time: further ones are refused. With
/// --boot-elf the boards start through the bootloader, and `actuator update` works on them. Several
/// programs, and native actuators beside them, share the bus if --elf is repeated.
///
/// With `--protocol dronecan` the actuators are DroneCAN nodes, which the network gives their
/// node-IDs. With another protocol the server runs servos on a serial bus instead, for the
/// libraries of their makers. With --elf too, the servos are emulated actuator boards on one
/// half-duplex line, which has one client at a time; there is no communication board.
#[derive(Debug, Args)]
pub struct Serve {
    /// Address and port of the server; port 0 selects a free one
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:29536")]
    listen: SocketAddr,
    /// Provides a pseudo-terminal instead, whose path is in the line on standard output
    #[cfg(unix)]
    #[arg(long, conflicts_with = "listen")]
    pty: bool,
    /// Number of actuators, with node-IDs from 1 [default: one, or one for each --elf]
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(u8).range(1..=127))]
    nodes: Option<u8>,
    /// The actuators wait for a node-ID by LSS; their serial numbers start at 1
    #[arg(long, conflicts_with = "emulated")]
    unconfigured: bool,
    /// Seed of noise, friction and magnet misalignment, which differ between actuators [default:
    /// ideal; 0 with --elf]
    #[arg(long, value_name = "NUMBER")]
    seed: Option<u64>,
    /// Faults as they are written to this file or pipe, one a line; `-` for standard input
    ///
    /// The number of an actuator and `encoder-lost`, `encoder-back`, `jam`, `free`, `load NM`,
    /// `supply VOLTS`, `bus-off`, `bus-on`, `sdo-delay MS`, `mute` (no heartbeats) or `unmute`. An
    /// emulated board takes those of its shaft, its encoder and its supply.
    #[arg(long, value_name = "FILE", conflicts_with = "protocol")]
    node_faults: Option<PathBuf>,
    #[command(flatten)]
    boards: Boards,
    #[command(flatten)]
    servos: Servos,
    #[command(flatten)]
    loads: Loads,
    /// Also provides the bus with this number by UDP multicast, as the simulator of ArduPilot does
    #[arg(long, value_name = "BUS", conflicts_with = "emulated")]
    #[arg(value_parser = clap::value_parser!(u8).range(0..=9))]
    multicast: Option<u8>,
    /// Makes this path a link to the pseudo-terminal, until the end
    #[cfg(unix)]
    #[arg(long, value_name = "PATH", requires = "pty")]
    link: Option<PathBuf>,
}

/// The link to a pseudo-terminal.
#[cfg(all(feature = "board", unix))]
type Link = terminal::Link;
#[cfg(all(feature = "board", not(unix)))]
type Link = std::convert::Infallible;

/// A transport to the serial line, its address, and the link to it.
#[cfg(feature = "board")]
type Endpoint = (Box<dyn crate::emulated::Transport>, String, Option<Link>);

impl Serve {
    /// Runs the server until an interrupt.
    ///
    /// # Errors
    /// For an address that is not available.
    pub fn run(&self) -> Result<(), Error> {
        let stop = interrupt::stop()?;
        let boards = self.boards.with_folder();
        let count = self.check(&boards)?;
        if !boards.elf.is_empty() {
            return self.emulate(&boards, count, &stop);
        }
        if let Some(servos) = self.servos.serve(count, &self.loads)? {
            #[cfg(unix)]
            if self.pty {
                let (terminal, address, _link) = self.open_linked()?;
                let servos = servos.with(Terminal(terminal), &address)?;
                return servos.run(None, &address, &stop);
            }
            let (listener, address) = self.listen()?;
            return servos.run(Some(listener), &address, &stop);
        }
        let mut buffers = vec![vec![0; CAPTURE_VALUES]; usize::from(count)];
        let nodes = (1..).zip(&mut buffers).map(|(number, buffer)| {
            let plant = self.plant_options(number, self.seed);
            if self.servos.is_dronecan() {
                return NativeNode::with_dronecan(number, &plant, buffer);
            }
            let node_id = NodeId::new(number).filter(|_| !self.unconfigured);
            NativeNode::new(u32::from(number), node_id, &plant, buffer)
        });
        let mut bus = Bus::new(nodes.collect::<Result<_, _>>()?);
        if let Some(faults) = self.faults(vec![false; count.into()]) {
            bus.set_faults(faults);
        }
        let mut server = Server::new(bus);
        #[cfg(unix)]
        if self.pty {
            let (terminal, address, _link) = self.open_linked()?;
            server.add("the terminal", Terminal(terminal));
            self.ready(&address, count)?;
            return run(&mut server, None, &stop, &address);
        }
        let (listener, address) = self.listen()?;
        let multicast = self.multicast.map(|bus| multicast::join(bus, &address));
        multicast.transpose().map_err(|source| Error::Serve {
            address: "the multicast group".into(),
            source,
        })?;
        self.ready(&address, count)?;
        run(&mut server, Some(listener), &stop, &address)
    }

    /// The faults at run time, of actuators of which these are emulated.
    fn faults(&self, are_emulated: Vec<bool>) -> Option<Receiver<Fault>> {
        let path = self.node_faults.clone()?;
        let (sender, faults) = mpsc::channel();
        let refused = move |fault: &Fault| match are_emulated.get(fault.node - 1) {
            None => Some(format!("the bus has {} actuators", are_emulated.len())),
            Some(true) if !fault.change.is_of_plant() => {
                Some("an emulated board has no such fault".to_owned())
            }
            Some(_) => None,
        };
        thread::spawn(move || read_faults(&path, refused, &sender));
        Some(faults)
    }

    /// The number of actuators, and no options that contradict each other.
    fn check(&self, boards: &Boards) -> Result<u8, Error> {
        let is_serial = self.servos.is_serial();
        self.boards.check(is_serial)?;
        if is_serial && boards.elf.is_empty() && self.seed.is_some() {
            return Err(Error::Conflict(
                "--seed concerns actuators, and this protocol has simulated servos without --elf"
                    .into(),
            ));
        }
        if self.multicast.is_some() && (self.servos.is_serial() || self.is_terminal()) {
            return Err(Error::Conflict(
                "--multicast needs a CAN bus, and a server at --listen".into(),
            ));
        }
        let count = boards.count(self.nodes)?;
        self.loads.check(count)?;
        if is_serial && !boards.elf.is_empty() {
            self.servos.check_boards(count)?;
        }
        Ok(count)
    }

    #[cfg(unix)]
    fn is_terminal(&self) -> bool {
        self.pty
    }

    #[cfg(not(unix))]
    fn is_terminal(&self) -> bool {
        false
    }

    /// A pseudo-terminal, its address, and the link to it.
    #[cfg(unix)]
    fn open_linked(&self) -> Result<(std::fs::File, String, Option<terminal::Link>), Error> {
        let (terminal, address) = open_terminal()?;
        let link = self.link.as_deref().map(|path| {
            terminal::Link::new(path, Path::new(&address)).map_err(|source| Error::Serve {
                address: path.display().to_string(),
                source,
            })
        });
        Ok((terminal, address, link.transpose()?))
    }

    /// Options of the board plant of an actuator: ideal without a seed.
    fn plant_options(&self, number: u8, seed: Option<u64>) -> BoardPlantOptions {
        let mut options = seed.map_or_else(BoardPlantOptions::default, |seed| {
            BoardPlantOptions::realistic(seed.wrapping_add(u64::from(number)))
        });
        options.drivetrain.load = self.loads.of(number);
        options
    }

    #[cfg(feature = "board")]
    fn emulate(&self, boards: &Boards, count: u8, stop: &Arc<AtomicBool>) -> Result<(), Error> {
        use crate::emulated;
        let programs = boards.read(self.servos.interface())?;
        // A serial bus has no communication board, not even one of --boards.
        let comm = boards.comm_elf.as_deref();
        let comm = comm.filter(|_| !self.servos.is_serial());
        let comm = comm.map(emulated::comm_board).transpose()?;
        let seed = self.seed.or(Some(0));
        let plants: Vec<_> = (1..=count)
            .map(|number| self.plant_options(number, seed))
            .collect();
        let (transport, address, _link) = self.endpoint(match comm {
            Some(_) => "the serial line of the communication board",
            None => "the serial bus",
        })?;
        let line = match comm {
            Some(_) => self.ready_line(&address, count, programs.kind(count)),
            None => self.servos.boards_line(&address, count),
        };
        // The server also runs if nothing reads the line.
        let ready = Box::new(move || drop(print(&line)));
        let served = match comm {
            Some(comm) => {
                let are_emulated = (1..=count).map(|number| programs.of(number).is_some());
                let faults = self.faults(are_emulated.collect());
                let programs = (&programs, &comm);
                emulated::serve(programs, &plants, faults, transport, ready, stop)
            }
            None => {
                let faults = self.servos.board_faults(count);
                emulated::serve_servos(&programs, &plants, faults, transport, ready, stop)
            }
        };
        served.map_err(Error::Board)
    }

    /// Where the client of this serial line of emulated boards connects.
    #[cfg(feature = "board")]
    fn endpoint(&self, line: &'static str) -> Result<Endpoint, Error> {
        #[cfg(unix)]
        if self.pty {
            let (terminal, address, link) = self.open_linked()?;
            return Ok((Box::new(crate::emulated::Terminal(terminal)), address, link));
        }
        let (listener, address) = self.listen()?;
        let server = crate::emulated::TcpServer::new(listener, line);
        Ok((Box::new(server), address, None))
    }

    #[cfg(not(feature = "board"))]
    fn emulate(&self, _: &Boards, _: u8, _: &Arc<AtomicBool>) -> Result<(), Error> {
        Err(Error::Conflict(
            "this program was built without the emulator; one that has it is built by \
             `cargo emulate serve`"
                .into(),
        ))
    }

    /// A listener and its address.
    fn listen(&self) -> Result<(TcpListener, String), Error> {
        let listener = listen(self.listen).map_err(|source| Error::Serve {
            address: self.listen.to_string(),
            source,
        })?;
        let address = listener.local_addr().unwrap_or(self.listen);
        if !address.ip().is_loopback() {
            note!(
                "warning: {address} can be reached from other computers, which can then command the actuators"
            );
        }
        Ok((listener, address.to_string()))
    }

    fn ready(&self, address: &str, count: u8) -> Result<(), Error> {
        print(&self.ready_line(address, count, ""))
    }

    fn ready_line(&self, address: &str, count: u8, kind: &str) -> String {
        let ids = match (self.unconfigured, count) {
            _ if self.servos.is_dronecan() => "with DroneCAN, actuator-IDs from 1".to_owned(),
            (true, _) => "without node-IDs".to_owned(),
            (_, 1) => "with node-ID 1".to_owned(),
            (_, most) => format!("with node-IDs 1 to {most}"),
        };
        let what = if count == 1 { "actuator" } else { "actuators" };
        format!("ready: slcan at {address}, {count} {kind}{what} {ids}\n")
    }
}

#[cfg(unix)]
fn open_terminal() -> Result<(std::fs::File, String), Error> {
    let opened = terminal::open().map_err(|source| Error::Serve {
        address: "a pseudo-terminal".into(),
        source,
    });
    opened.map(|(terminal, path)| (terminal, path.display().to_string()))
}

fn listen(address: SocketAddr) -> std::io::Result<TcpListener> {
    let listener = TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    Ok(listener)
}

fn run(
    server: &mut Server<'_>,
    listener: Option<TcpListener>,
    stop: &AtomicBool,
    address: &str,
) -> Result<(), Error> {
    let address = address.to_owned();
    // The server also runs if nothing reads its notices.
    let mut notify = |notice: &Notice| drop(writeln!(io::stderr(), "{notice}"));
    let done = server.run(listener, stop, &mut notify);
    done.map_err(|source| Error::Serve { address, source })
}
