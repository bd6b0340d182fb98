//! What is known of a node of the bus.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::{Duration, Instant};

use canopen::cia402::statusword;
use host_sim::can::client::state_name;
use host_sim::can::fault_history::descriptions;
use host_sim::can::mapped::Originals;
use host_sim::can::scan::Device;
use host_sim::can::telemetry::Telemetry;
use serde_json::{Value, json};

use crate::bus::decode::nmt_state;
use crate::guarded::Guard;
use crate::record::Record;
use crate::servos::Servo;
use crate::web::PageId;

/// Period of the heartbeats that this program requests of a node, ms.
pub const HEARTBEAT_MS: u16 = 100;

/// Time without a heartbeat after which a node counts as lost: five periods.
const LOST: Duration = Duration::from_millis(5 * HEARTBEAT_MS as u64);

/// What a page commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// An angle, mdeg.
    Angle(i32),
    /// A rate, mdeg/s.
    Rate(i32),
    /// A torque at the output, uN m.
    Torque(i32),
}

/// A node.
#[derive(Default)]
pub struct Node {
    /// Its identity.
    pub device: Device,
    /// Whether it is an actuator of this project, whose objects are known.
    pub is_actuator: bool,
    /// What is known of it if it is a servo of a serial bus.
    pub servo: Option<Servo>,
    /// Whether it is set up for this program.
    pub is_attached: bool,
    /// Why it could not be set up.
    pub problem: Option<String>,
    /// NMT state by its last heartbeat.
    pub nmt: Option<u8>,
    /// Time of its last heartbeat.
    pub heartbeat: Option<Instant>,
    /// Its heartbeat has ceased.
    pub is_lost: bool,
    /// Decoder of its TPDOs.
    pub telemetry: Option<Telemetry>,
    /// Its samples.
    pub record: Record,
    /// Its last statusword.
    pub statusword: Option<u16>,
    /// Its last mode of operation.
    pub mode: i8,
    /// Bits of the present faults.
    pub present: i64,
    /// Bits of the latched faults.
    pub latched: i64,
    /// The page on whose request it is enabled.
    pub enabled_by: Option<PageId>,
    /// The page on whose request it is commissioned, which enables and disables its drive, and the
    /// stops since.
    pub commissioned_by: Option<(PageId, Guard)>,
    /// It monitors the heartbeat of this program, which must continue until the monitoring ends.
    pub is_watching: bool,
    /// A stop was requested, and the drive is not off yet.
    pub is_stopping: bool,
    /// Number of stops: a job that started before the last one must not send.
    pub stops: Arc<AtomicU64>,
    /// The last target that is not commanded yet.
    pub target: Option<Target>,
    /// Addresses of the objects that were written and not saved since.
    pub unsaved: BTreeSet<String>,
    /// Objects with their values before this program changed them, in the order to write them back.
    pub original: Originals,
}

impl Node {
    /// Whether its drive follows commands.
    pub fn is_enabled(&self) -> bool {
        self.statusword.is_some_and(|word| word & 0x6F == 0x27)
    }

    /// Whether its drive moves or may move: enabled or decelerating.
    pub fn is_powered(&self) -> bool {
        let servo = self.servo.as_ref();
        servo.is_some_and(|servo| servo.is_torque_on)
            || (self.statusword).is_some_and(|word| word & 0x6F == 0x27 || word & 0x6F == 0x07)
    }

    /// The page on whose request it moves or may move. A commissioning that was stopped moves
    /// nothing more: it restores the parameters of before.
    pub fn moved_by(&self) -> Option<PageId> {
        let commissioned = self.commissioned_by.as_ref();
        let moving = commissioned.filter(|(_, guard)| !guard.is_stopped());
        self.enabled_by.or(moving.map(|(page, _)| *page))
    }

    /// Whether it takes the targets of pages.
    pub fn takes_targets(&self) -> bool {
        self.is_enabled() && !self.is_stopping && self.commissioned_by.is_none()
    }

    /// Whether its drive has a fault.
    pub fn has_fault(&self) -> bool {
        self.statusword
            .is_some_and(|word| word & statusword::FAULT != 0)
    }

    /// Whether it has a fault, or the cause of one.
    pub fn has_faults(&self) -> bool {
        self.has_fault() || self.present != 0 || self.latched != 0
    }

    /// Notes that a heartbeat has ceased; whether that is new.
    pub fn check_heartbeat(&mut self, now: Instant) -> bool {
        let is_late = self.heartbeat.is_some_and(|last| now - last > LOST);
        if !is_late || self.is_lost {
            return false;
        }
        self.is_lost = true;
        true
    }

    /// The state of the drive in words.
    pub fn state(&self) -> Option<&'static str> {
        self.statusword.map(state_name).or(self.device.state)
    }

    /// Everything for the page.
    pub fn snapshot(&self, number: u8) -> Value {
        let names = |bits| -> Vec<_> { descriptions(bits).map(|row| row.fault.number()).collect() };
        let mut snapshot = json!({
            "node": number,
            "name": self.device.name, "software": self.device.software,
            "product": self.device.product, "serial": self.device.serial,
            "is_actuator": self.is_actuator, "is_attached": self.is_attached,
            "problem": self.problem,
            "network": self.nmt.map(nmt_state), "is_lost": self.is_lost,
            "state": self.state(), "statusword": self.statusword, "mode": self.mode,
            "is_enabled": self.is_enabled(), "has_fault": self.has_fault(),
            "is_stopping": self.is_stopping, "enabled_by": self.enabled_by,
            "is_commissioned": self.commissioned_by.is_some(),
            "present": names(self.present), "latched": names(self.latched),
            "lost_samples": self.record.lost, "unsaved": self.unsaved,
        });
        if let (Some(servo), Value::Object(entries)) = (&self.servo, &mut snapshot) {
            entries.extend(servo.snapshot(self));
        }
        snapshot
    }
}
