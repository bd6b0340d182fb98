//! A bench in the time of the simulation.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use canopen::NodeId;
use model_core::plant::board::{BoardPlantOptions, Defects};
use model_core::time::CONTROL_PERIOD_S;

use crate::can::client::Client;
use crate::can::link::Link;
use crate::can::native_link::NativeLink;
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

/// What observes the shaft of a bench, and holds it.
struct Observer {
    moved: Arc<Mutex<Moved>>,
    /// The angle after the last control period, deg.
    angle_deg: f64,
    /// The shaft must not be beyond this angle, deg.
    limit_deg: f64,
    /// An angle at which the shaft sticks when it passes it first, deg, and until when, us.
    sticks: Option<(f64, Option<u64>)>,
}

impl Observer {
    /// A control period, in which the shaft is within the range.
    fn observe(&mut self, node: &mut NativeNode<'static>) {
        let angle_deg = node.angle_deg();
        let now_us = node.next_us();
        if let Some((at_deg, until_us)) = &mut self.sticks {
            if until_us.is_none() && angle_deg > *at_deg {
                *until_us = Some(now_us + 600_000);
            }
            node.defects().is_jammed = until_us.is_some_and(|until_us| now_us < until_us);
        }
        assert!(angle_deg.abs() <= self.limit_deg, "{angle_deg} deg");
        let before_deg = std::mem::replace(&mut self.angle_deg, angle_deg);
        let rate_deg_s = (angle_deg - before_deg).abs() / CONTROL_PERIOD_S;
        let mut moved = self.moved.lock().expect("no other thread");
        moved.greatest_deg_s = moved.greatest_deg_s.max(rate_deg_s);
        if rate_deg_s > MOVING_DEG_S {
            moved.moving_s += CONTROL_PERIOD_S;
        }
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
    let mut observer = Observer {
        moved: Arc::clone(&moved),
        angle_deg: node.angle_deg(),
        limit_deg: limit_deg.min(options.drivetrain.gear_train.hard_stop_deg),
        sticks,
    };
    let mut link = NativeLink::new(node, move |node| observer.observe(node));
    // The start of the node.
    link.pause(Duration::from_millis(100)).expect("no input");
    (Client::new(Box::new(link), 1), moved)
}
