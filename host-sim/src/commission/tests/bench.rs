//! A bench in the time of the simulation, and a small servo with secret parameters on it.

use std::io;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use canopen::{CanFrame, NodeId};
use model_core::plant::board::{BoardPlantOptions, Defects};
use model_core::sensors::noise::Noise;
use model_core::time::CONTROL_PERIOD_S;

use crate::can::client::Client;
use crate::can::link::Link;
use crate::can::native_node::{CAPTURE_VALUES, NativeNode};
use crate::commission::Limits;

/// How the shaft has moved.
#[derive(Debug, Default)]
pub struct Moved {
    /// Time in which it turned, s.
    pub moving_s: f64,
    /// Greatest rate, deg/s.
    pub greatest_deg_s: f64,
}

/// A bus of one node whose time goes on while the client waits.
struct Bench {
    moved: Arc<Mutex<Moved>>,
    node: NativeNode<'static>,
    /// The shaft must not be beyond this angle, deg.
    limit_deg: f64,
    /// An angle at which the shaft sticks when it passes it first, deg, and until when, us.
    sticks: Option<(f64, Option<u64>)>,
}

impl Bench {
    /// A control period, in which the shaft is within the range.
    fn step(&mut self) {
        let before_deg = self.node.angle_deg();
        self.node.step(self.node.next_us());
        let now_us = self.node.next_us();
        if let Some((at_deg, until_us)) = &mut self.sticks {
            if until_us.is_none() && self.node.angle_deg() > *at_deg {
                *until_us = Some(now_us + 600_000);
            }
            self.node.defects().is_jammed = until_us.is_some_and(|until_us| now_us < until_us);
        }
        let angle_deg = self.node.angle_deg();
        assert!(angle_deg.abs() <= self.limit_deg, "{angle_deg} deg");
        let rate_deg_s = (angle_deg - before_deg).abs() / CONTROL_PERIOD_S;
        let mut moved = self.moved.lock().expect("no other thread");
        moved.greatest_deg_s = moved.greatest_deg_s.max(rate_deg_s);
        if rate_deg_s > MOVING_DEG_S {
            moved.moving_s += CONTROL_PERIOD_S;
        }
    }
}

impl Link for Bench {
    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.node.receive(frame);
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> io::Result<Option<CanFrame>> {
        let end = self.node.next_us() + timeout.as_micros() as u64;
        loop {
            if let Some(frame) = self.node.transmit() {
                return Ok(Some(frame));
            }
            if self.node.next_us() > end {
                return Ok(None);
            }
            self.step();
        }
    }

    fn pause(&mut self, time: Duration) -> io::Result<()> {
        let end = self.node.next_us() + time.as_micros() as u64;
        while self.node.next_us() < end {
            self.step();
            while self.node.transmit().is_some() {}
        }
        Ok(())
    }
}

/// A shaft that turns, deg/s: the noise of a resting one is below a tenth of it.
const MOVING_DEG_S: f64 = 1.0;

/// The range of the bench, and its rated current.
pub const LIMITS: Limits = Limits {
    range_mdeg: Some((-45_000, 45_000)),
    permille: 1000,
    rate_mdeg_s: 120_000,
};

/// A client of a bench whose shaft must not leave the range.
pub fn client(options: &BoardPlantOptions, defects: Defects) -> Client {
    client_within(options, defects, 45.0)
}

/// That of a bench whose shaft must not be beyond an angle, deg.
pub fn client_within(options: &BoardPlantOptions, defects: Defects, limit_deg: f64) -> Client {
    client_of(options, defects, limit_deg, None)
}

/// A client of a bench whose shaft must not be beyond an angle, deg, and how the shaft moves.
pub fn observed_client(options: &BoardPlantOptions, limit_deg: f64) -> (Client, Arc<Mutex<Moved>>) {
    bench_of(options, Defects::default(), limit_deg, None)
}

/// That of a shaft that sticks for 0.6 s when it first passes an angle, deg.
pub fn client_of(
    options: &BoardPlantOptions,
    defects: Defects,
    limit_deg: f64,
    sticks_at_deg: Option<f64>,
) -> Client {
    bench_of(options, defects, limit_deg, sticks_at_deg).0
}

fn bench_of(
    options: &BoardPlantOptions,
    defects: Defects,
    limit_deg: f64,
    sticks_at_deg: Option<f64>,
) -> (Client, Arc<Mutex<Moved>>) {
    let moved = Arc::default();
    let sticks = sticks_at_deg.map(|at_deg| (at_deg, None));
    let buffer = Box::leak(Box::new([0; CAPTURE_VALUES]));
    let mut node = NativeNode::new(1, NodeId::new(1), options, buffer).expect("a plant");
    *node.defects() = defects;
    let mut bench = Bench {
        moved: Arc::clone(&moved),
        node,
        limit_deg: limit_deg.min(options.drivetrain.gear_train.hard_stop_deg),
        sticks,
    };
    // The start of the node.
    bench.pause(Duration::from_millis(100)).expect("no input");
    (Client::new(Box::new(bench), 1), moved)
}

/// A small servo: motor, gears and source differ from those of the board's defaults, the magnet is
/// eccentric in any direction.
pub fn secret(seed: u64) -> BoardPlantOptions {
    let mut options = BoardPlantOptions::realistic(seed);
    let mut chance = Noise::new(seed, 41);
    let mut spread = || 1.0 + chance.gaussian(0.15).clamp(-0.33, 0.33);
    let motor = &mut options.drivetrain.electrical;
    motor.torque_constant_nm_a *= spread();
    motor.winding_resistance_ohm *= spread();
    motor.winding_inductance_h *= spread();
    // 4.9 V to 7.4 V, four to six cells.
    motor.supply_v = 6.15 * spread().clamp(0.8, 1.2);
    options.supply.source_resistance_ohm *= spread();
    let gears = &mut options.drivetrain.gear_train;
    // Together with the torque constant still what the plausibility checks of the motor permit.
    gears.gear_ratio *= 1.0 + (spread() - 1.0) / 3.0;
    gears.motor_inertia_kg_m2 *= spread();
    gears.gear_stiffness_nm_deg *= spread();
    gears.backlash_deg *= 1.0 + 2.0 * (spread() - 0.67) / 0.33;
    // Eccentric in any direction.
    options.encoder.misalignment_first_phase_deg = chance.gaussian(1e3) % 360.0;
    options
}
