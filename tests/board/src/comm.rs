//! A client on the serial line of the communication board.

use std::sync::OnceLock;

use virtual_board::can::{Port, Sent};
use virtual_board::run::{
    CommFinished, CommOptions, CommView, Firmware, Flow, SerialScript, SharedBus, run_comm,
};

use cross_build::comm_board_elf;

/// Poll period of the serial line, ns: a text begins at a poll.
pub const POLL_NS: u64 = 100_000;

/// The communication board's program.
///
/// # Panics
/// If it does not build.
pub fn comm_firmware() -> &'static Firmware {
    static FIRMWARE: OnceLock<Firmware> = OnceLock::new();
    FIRMWARE.get_or_init(|| Firmware::read(comm_board_elf()).expect("an ELF file"))
}

/// A client that sends texts at given instants, us, and records what it receives.
pub struct Client {
    plan: std::vec::IntoIter<(u64, Vec<u8>)>,
    next: Option<(u64, Vec<u8>)>,
    /// The bytes of the board with the ends of their stop bits, ns.
    pub received: Vec<(u64, u8)>,
}

impl Client {
    /// A client that sends these texts.
    pub fn new(plan: Vec<(u64, Vec<u8>)>) -> Self {
        Self {
            plan: plan.into_iter(),
            next: None,
            received: Vec::new(),
        }
    }

    /// The received lines with the end of each, ns; BEL is a line of its own.
    pub fn lines(&self) -> Vec<(u64, String)> {
        let mut lines = Vec::new();
        let mut line = String::new();
        for &(at_ns, byte) in &self.received {
            match byte {
                b'\r' => lines.push((at_ns, std::mem::take(&mut line))),
                7 => lines.push((at_ns, "BEL".to_owned())),
                byte => line.push(char::from(byte)),
            }
        }
        lines
    }
}

impl SerialScript for Client {
    fn at_poll(&mut self, view: &mut CommView<'_>) -> Flow {
        let now_ns = view.now_ns();
        let serial = view.serial().expect("the board has a serial line");
        self.received.extend(serial.take_received());
        while let Some((at_us, text)) = self.next.take().or_else(|| self.plan.next()) {
            if at_us * 1000 > now_ns {
                self.next = Some((at_us, text));
                break;
            }
            serial.send(now_ns, &text);
        }
        Flow::Continue
    }
}

/// A finished run with a client.
pub struct ClientRun {
    /// The client.
    pub client: Client,
    /// Frames that were on the bus; the board is station 0, the ports follow.
    pub log: Vec<Sent>,
    /// The bus.
    pub bus: SharedBus,
}

/// Runs the communication board with this script, alone on the bus with its ports, for this many
/// ms, and asserts that the emulation had no gap and the board no reset.
///
/// # Panics
/// If there was one, or the run fails.
pub fn run_comm_script<S: SerialScript + 'static>(
    bus: &SharedBus,
    script: S,
    ms: u64,
) -> CommFinished<S> {
    let options = CommOptions {
        bus: bus.connections().remove(0),
        poll_ns: POLL_NS,
        until_ns: ms * 1_000_000,
        interrupt: None,
    };
    let finished = run_comm(comm_firmware(), options, script).expect("the run succeeds");
    assert!(finished.gaps.is_empty(), "{}", finished.gaps);
    assert!(finished.resets.is_empty(), "{:?}", finished.resets);
    finished
}

/// Runs the communication board with a client that sends these texts.
///
/// # Panics
/// As [`run_comm_script`].
pub fn run_client(ports: Vec<Port>, plan: Vec<(u64, Vec<u8>)>, ms: u64) -> ClientRun {
    let bus = SharedBus::new(ports, 1);
    let finished = run_comm_script(&bus, Client::new(plan), ms);
    ClientRun {
        client: finished.script,
        log: bus.take_log(),
        bus,
    }
}

/// A plan: one text per millisecond from 5 ms on.
pub fn one_per_ms<T: AsRef<[u8]>>(texts: &[T]) -> Vec<(u64, Vec<u8>)> {
    let texts = (5..).zip(texts);
    texts
        .map(|(ms, text)| (ms * 1000, text.as_ref().to_vec()))
        .collect()
}
