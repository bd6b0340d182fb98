//! A client of the emulated board, with which its actuator is commissioned.

use std::io;
use std::thread;
use std::time::Duration;

use host_sim::can::client::Client;
use host_sim::can::link::Link;
use model_core::plant::board::Defects;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{ClientSide, Flow, Options, Requests, RunSide, Script, View, client};

use board_tests::frames::{Frame, from_wire, to_wire};
use board_tests::program::run_script;

/// Longest run, ms.
const LONGEST_MS: u64 = 3_600_000;

struct BoardLink(ClientSide);

impl Link for BoardLink {
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        self.0.send(to_wire(frame))
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<Frame>> {
        Ok(self.0.receive(timeout)?.as_ref().map(from_wire))
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        self.0.pause(time)
    }
}

/// Ends the run, after a panic of the client too.
struct EndOnDrop(Requests);

impl Drop for EndOnDrop {
    fn drop(&mut self) {
        // A run that has ended shows why when it is joined.
        let _ = self.0.end();
    }
}

struct Bench {
    run_side: RunSide,
    defects: Defects,
    limit_deg: f64,
}

impl Script for Bench {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        view.plant.defects = self.defects;
        let angle_deg = view.row.angle_deg;
        assert!(angle_deg.abs() <= self.limit_deg, "{angle_deg} deg");
        let port = view.port(0).expect("a port");
        let frames = port.take_received().into_iter().map(|(_, frame)| frame);
        self.run_side.exchange(view, frames)
    }
}

/// Runs `work` with a client of an emulated board on this plant with these defects, whose shaft
/// must not be beyond an angle.
///
/// # Panics
/// If the shaft is, the emulation has a gap, or `work` panics.
pub fn with_board<T>(
    plant: &BoardPlantOptions,
    defects: Defects,
    limit_deg: f64,
    work: impl FnOnce(&mut Client) -> T,
) -> T {
    let (side, run_side) = client();
    let script = Bench {
        run_side,
        defects,
        limit_deg,
    };
    let options = Options {
        plant: *plant,
        keeps_trace: false,
        ..Options::for_ms(LONGEST_MS)
    };
    let end = EndOnDrop(side.requests());
    let run = thread::spawn(move || run_script(options, script));
    let mut client = Client::new(Box::new(BoardLink(side)), 1);
    // The start of the node.
    let started = client.pause(Duration::from_millis(100));
    started.expect("the run goes on");
    let result = work(&mut client);
    drop(end);
    run.join().expect("a run without a panic");
    result
}
