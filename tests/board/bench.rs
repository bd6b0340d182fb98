//! A client of the emulated board, with which its actuator is commissioned.

use std::io::{self, ErrorKind};
use std::thread;
use std::time::Duration;

use firmware::parameters::ObjectValues;
use host_sim::can::client::Client;
use host_sim::can::link::Link;
use model_core::plant::board::{Bridge, Defects, PERIOD_CYCLES};
use model_core::plant::drivetrain::DrivetrainParameters;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{ClientSide, Flow, Options, Requests, RunSide, Script, View, client};
use virtual_board::trace::Row;

use board_tests::frames::{Frame, from_wire, to_wire};
use board_tests::program::run_script;

/// Longest run, ms.
const LONGEST_MS: u64 = 3_600_000;

/// Longest virtual time without a response. The client's own limit is in real time, in which the
/// board runs for a minute.
const SILENT: Duration = Duration::from_secs(5);

struct BoardLink {
    side: ClientSide,
    /// Time since the last frame of either side.
    silent: Duration,
}

impl Link for BoardLink {
    fn send(&mut self, frame: &Frame) -> io::Result<()> {
        self.silent = Duration::ZERO;
        self.side.send(to_wire(frame))
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<Frame>> {
        let frame = self.side.receive(timeout)?;
        match frame {
            Some(_) => self.silent = Duration::ZERO,
            None => self.silent += timeout,
        }
        if self.silent > SILENT {
            return Err(io::Error::new(ErrorKind::TimedOut, "the board is silent"));
        }
        Ok(frame.as_ref().map(from_wire))
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        self.side.pause(time)
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

/// What the shaft and the motor of a bench must not exceed.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Angle of the shaft, deg.
    pub angle_deg: f64,
    /// Mean current over two control periods that drives the shaft, A. Until the resistance is
    /// measured it is that of a motor with 2011h:1. A brake may have more.
    pub driving_a: f64,
}

/// A commissioning has measured the resistance before this time, ns.
const MEASURED_NS: u64 = 5_000_000_000;

struct Bench {
    run_side: RunSide,
    defects: Defects,
    bounds: Bounds,
    motor: DrivetrainParameters,
    /// Mean currents of the last PWM periods, A.
    driving_a: [f64; 8],
}

impl Bench {
    /// The mean current of a PWM period that drives the shaft, A: the winding settles within it.
    fn driving_a(&self, row: &Row) -> f64 {
        let motor = &self.motor.electrical;
        match row.bridge {
            Bridge::Driven {
                is_positive,
                on_cycles,
            } if row.rate_deg_s == 0.0 || is_positive == (row.rate_deg_s > 0.0) => {
                let v_s_rad = motor.torque_constant_nm_a * self.motor.gear_train.gear_ratio;
                let duty = f64::from(on_cycles) / f64::from(PERIOD_CYCLES);
                let back_emf_v = v_s_rad * row.rate_deg_s.abs().to_radians();
                (duty * row.supply_v - back_emf_v) / motor.winding_resistance_ohm
            }
            _ => 0.0,
        }
    }

    fn check(&mut self, row: &Row) {
        let angle_deg = row.angle_deg;
        assert!(angle_deg.abs() <= self.bounds.angle_deg, "{angle_deg} deg");
        self.driving_a.rotate_left(1);
        self.driving_a[7] = self.driving_a(row);
        let mean_a = self.driving_a.iter().sum::<f64>() / 8.0;
        let assumed_ohm = ObjectValues::DEFAULT.model.resistance_ohm;
        let by_ohm = f64::from(assumed_ohm) / self.motor.electrical.winding_resistance_ohm;
        let most_a = match row.at_ns < MEASURED_NS {
            true => self.bounds.driving_a * by_ohm.max(1.0),
            // Three standard errors of the resistance.
            false => self.bounds.driving_a * 1.04,
        };
        assert!(mean_a <= most_a, "{mean_a} A at {} ns", row.at_ns);
    }
}

impl Script for Bench {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        view.plant.defects = self.defects;
        self.check(view.row);
        let port = view.port(0).expect("a port");
        let frames = port.take_received().into_iter().map(|(_, frame)| frame);
        self.run_side.exchange(view, frames)
    }
}

/// Runs `work` with a client of an emulated board on this plant with these defects, and requests to
/// its run.
///
/// # Panics
/// If a bound is exceeded, the emulation has a gap, or `work` panics.
pub fn with_board<T>(
    plant: &BoardPlantOptions,
    defects: Defects,
    bounds: Bounds,
    work: impl FnOnce(&mut Client, &Requests) -> T,
) -> T {
    let (side, run_side) = client();
    let script = Bench {
        run_side,
        defects,
        bounds,
        motor: plant.drivetrain,
        driving_a: [0.0; 8],
    };
    let options = Options {
        plant: *plant,
        keeps_trace: false,
        ..Options::for_ms(LONGEST_MS)
    };
    let end = EndOnDrop(side.requests());
    let run = thread::spawn(move || run_script(options, script));
    let silent = Duration::ZERO;
    let mut client = Client::new(Box::new(BoardLink { side, silent }), 1);
    // The start of the node.
    let started = client.pause(Duration::from_millis(100));
    started.expect("the run goes on");
    let result = work(&mut client, &end.0);
    drop(end);
    run.join().expect("a run without a panic");
    result
}
