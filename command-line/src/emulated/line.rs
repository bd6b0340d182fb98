//! The communication board and the client of its serial line.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use virtual_board::run::{
    BusConnection, CommOptions, CommView, Firmware, Flow, SerialScript, run_comm,
};

use super::native::NativeActuators;
use super::transport::Transport;
use super::{FOR_EVER_NS, report};

/// Time between two polls of the client and of the native actuators, ns of virtual time.
const POLL_NS: u64 = 500_000;

/// Bytes in the receive buffer of the line; the operating system buffers more and blocks the
/// client.
const RECEIVE_BUFFER: usize = 256;

/// Bytes in the send buffer of the client; further lines are lost.
const SEND_BUFFER: usize = 1 << 16;

/// Time at which all boards have started, ns.
pub(super) const STARTED_NS: u64 = 50_000_000;

/// Runs the communication board until `stop` is set.
///
/// # Errors
/// Those of the emulator.
pub fn run(
    program: &Firmware,
    bus: BusConnection,
    line: SerialLine,
    stop: &Arc<AtomicBool>,
) -> Result<(), String> {
    let options = CommOptions {
        bus,
        poll_ns: POLL_NS,
        until_ns: FOR_EVER_NS,
        interrupt: Some(Arc::clone(stop)),
    };
    let finished = run_comm(program, options, line).map_err(|error| error.to_string())?;
    report("communication board", &finished.resets, &finished.gaps);
    Ok(())
}

/// The serial line and its client; the native actuators are polled with it.
pub struct SerialLine {
    transport: Box<dyn Transport>,
    native: NativeActuators,
    unread: Vec<u8>,
    is_skipping: bool,
    /// Called when the boards have started.
    ready: Option<Box<dyn FnOnce() + Send>>,
}

impl SerialLine {
    /// A line with this transport; calls `ready` once all boards have started.
    pub fn new(
        transport: Box<dyn Transport>,
        native: NativeActuators,
        ready: Box<dyn FnOnce() + Send>,
    ) -> Self {
        Self {
            transport,
            native,
            unread: Vec::new(),
            is_skipping: false,
            ready: Some(ready),
        }
    }

    /// Buffers a byte for the client; if the client does not read, whole lines are lost.
    fn buffer(&mut self, byte: u8) {
        if self.is_skipping {
            self.is_skipping = byte != b'\r';
            return;
        }
        self.unread.push(byte);
        if self.unread.len() > SEND_BUFFER {
            let last_end = self.unread.iter().rposition(|byte| *byte == b'\r');
            self.unread.truncate(last_end.map_or(0, |end| end + 1));
            self.is_skipping = byte != b'\r';
        }
    }
}

impl SerialScript for SerialLine {
    fn at_poll(&mut self, view: &mut CommView<'_>) -> Flow {
        let now_ns = view.now_ns();
        self.native.poll(now_ns);
        if now_ns >= STARTED_NS
            && let Some(ready) = self.ready.take()
        {
            ready();
        }
        let Some(serial) = view.serial() else {
            return Flow::End;
        };
        for (_, byte) in serial.take_received() {
            self.buffer(byte);
        }
        self.transport.write(&mut self.unread);
        let mut bytes = [0; RECEIVE_BUFFER];
        if serial.queued() < RECEIVE_BUFFER {
            let count = self.transport.read(&mut bytes);
            serial.send(now_ns, bytes.get(..count).unwrap_or_default());
        }
        Flow::Continue
    }
}
