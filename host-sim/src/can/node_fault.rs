//! Faults of native actuators and of their bus, as lines of text.

use std::collections::VecDeque;
use std::str::FromStr;

use canopen::CanFrame;
use embedded_can::Frame;
use model_core::plant::board::{Defects, EncoderWire, Stuck};

/// A fault of an actuator, or its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// The place of the actuator on the bus, from 1 on.
    pub node: usize,
    /// What begins or ends.
    pub change: Change,
}

/// What begins or ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// The encoder's data line is broken, or not.
    EncoderLost(bool),
    /// The gear train is stuck, or not.
    Jam(bool),
    /// This torque acts on the shaft, Nm.
    Load(f64),
    /// The supply has this voltage, V.
    Supply(f64),
    /// The controller is off the bus, or on it again.
    BusOff(bool),
    /// SDO responses come later by this time, us.
    SdoDelay(u64),
    /// No heartbeats are sent, or they are again.
    Mute(bool),
}

impl Change {
    /// Whether it concerns the shaft, the encoder or the supply, and not the bus.
    pub fn is_of_plant(self) -> bool {
        self.apply_to(&mut Defects::default())
    }

    /// Begins or ends a fault of the shaft, the encoder or the supply; returns false, without
    /// effect, for one of the bus.
    pub fn apply_to(self, defects: &mut Defects) -> bool {
        match self {
            Self::EncoderLost(is_lost) => {
                defects.encoder_wire = is_lost.then_some((EncoderWire::Data, Stuck::High));
            }
            Self::Jam(is_jammed) => defects.is_jammed = is_jammed,
            Self::Load(torque_nm) => defects.torque_nm = torque_nm,
            Self::Supply(volts) => defects.source_v = Some(volts),
            Self::BusOff(_) | Self::SdoDelay(_) | Self::Mute(_) => return false,
        }
        true
    }
}

/// A line that names no fault.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "fault `{0}`: expected the number of an actuator and one of `encoder-lost`, `encoder-back`, \
     `jam`, `free`, `load NM`, `supply VOLTS`, `bus-off`, `bus-on`, `sdo-delay MS`, `mute`, `unmute`"
)]
pub struct NoFault(String);

impl FromStr for Fault {
    type Err = NoFault;

    fn from_str(line: &str) -> Result<Self, NoFault> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let real = |word: &str| word.parse().ok().filter(|value: &f64| value.is_finite());
        let [node, ref what @ ..] = *words else {
            return Err(NoFault(line.trim().to_owned()));
        };
        let change = match *what {
            ["encoder-lost"] => Some(Change::EncoderLost(true)),
            ["encoder-back"] => Some(Change::EncoderLost(false)),
            ["jam"] => Some(Change::Jam(true)),
            ["free"] => Some(Change::Jam(false)),
            ["load", torque] => real(torque).map(Change::Load),
            ["supply", volts] => real(volts)
                .filter(|volts| (0.0..=60.0).contains(volts))
                .map(Change::Supply),
            ["bus-off"] => Some(Change::BusOff(true)),
            ["bus-on"] => Some(Change::BusOff(false)),
            ["sdo-delay", ms] => ms
                .parse()
                .ok()
                .filter(|ms| *ms <= LONGEST_DELAY_MS)
                .map(|ms: u64| Change::SdoDelay(1000 * ms)),
            ["mute"] => Some(Change::Mute(true)),
            ["unmute"] => Some(Change::Mute(false)),
            _ => None,
        };
        let node = node.parse().ok().filter(|node| *node > 0);
        (node.zip(change))
            .map(|(node, change)| Self { node, change })
            .ok_or_else(|| NoFault(line.trim().to_owned()))
    }
}

/// The longest delay of SDO responses, ms.
const LONGEST_DELAY_MS: u64 = 60_000;

/// The present faults that the plant does not know.
#[derive(Debug, Default)]
pub struct BusFaults {
    /// The controller is off the bus.
    pub is_off: bool,
    /// The encoder's data line is broken.
    pub is_encoder_lost: bool,
    delay_us: u64,
    is_mute: bool,
    /// Responses that wait, with the times at which they are due.
    delayed: VecDeque<(u64, CanFrame)>,
}

impl BusFaults {
    /// Begins or ends a fault.
    pub fn apply(&mut self, change: Change, defects: &mut Defects) {
        match change {
            Change::EncoderLost(is_lost) => self.is_encoder_lost = is_lost,
            Change::BusOff(is_off) => self.is_off = is_off,
            Change::SdoDelay(delay_us) => self.delay_us = delay_us,
            Change::Mute(is_mute) => self.is_mute = is_mute,
            of_plant => drop(of_plant.apply_to(defects)),
        }
    }

    /// What becomes of a frame that the actuator sends: `None` if it is lost or waits.
    pub fn pass(&mut self, frame: CanFrame, now_us: u64) -> Option<CanFrame> {
        let (id, _) = frame.raw_id();
        match id {
            _ if self.is_off => None,
            0x581..=0x5FF if self.delay_us > 0 || !self.delayed.is_empty() => {
                self.delayed.push_back((now_us + self.delay_us, frame));
                None
            }
            // A boot-up has the same identifier, and passes.
            0x701..=0x77F if self.is_mute && frame.data() != [0] => None,
            _ => Some(frame),
        }
    }

    /// A response that is due.
    pub fn due(&mut self, now_us: u64) -> Option<CanFrame> {
        let is_due = |(at_us, _): &(u64, CanFrame)| *at_us <= now_us;
        let frame = self.delayed.front().filter(|it| is_due(it))?.1;
        self.delayed.pop_front();
        (!self.is_off).then_some(frame)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc;

    use canopen::NodeId;
    use embedded_can::StandardId;

    use super::*;
    use crate::can::bus::Bus;
    use crate::can::native_node::{CAPTURE_VALUES, NativeNode, PERIOD_US};

    #[test]
    fn lines_name_faults_or_are_refused() {
        for (line, node, change) in [
            ("1 encoder-lost", 1, Change::EncoderLost(true)),
            (" 127  free ", 127, Change::Jam(false)),
            ("2 load -0.5", 2, Change::Load(-0.5)),
            ("3 supply 4.2", 3, Change::Supply(4.2)),
            ("1 bus-off", 1, Change::BusOff(true)),
            ("1 sdo-delay 250", 1, Change::SdoDelay(250_000)),
            ("1 unmute", 1, Change::Mute(false)),
        ] {
            assert_eq!(line.parse(), Ok(Fault { node, change }));
        }
        for line in [
            "",
            "jam",
            "0 jam",
            "1",
            "1 supply -1",
            "1 load nan",
            "1 sdo-delay x",
            "x mute",
        ] {
            assert!(line.parse::<Fault>().is_err(), "{line}");
        }
    }

    #[test]
    fn frames_are_lost_muted_or_wait_in_order() {
        let frame = |id, data: &[u8]| {
            CanFrame::new(StandardId::new(id).expect("11 bits"), data).expect("8 bytes at most")
        };
        let (response, heartbeat, boot_up) = (
            frame(0x581, &[0x60; 8]),
            frame(0x701, &[5]),
            frame(0x701, &[0]),
        );
        let (mut faults, mut defects) = (BusFaults::default(), Defects::default());
        assert_eq!(faults.pass(response, 0), Some(response));
        faults.apply(Change::Mute(true), &mut defects);
        assert_eq!(faults.pass(heartbeat, 0), None);
        assert_eq!(faults.pass(boot_up, 0), Some(boot_up));
        faults.apply(Change::SdoDelay(20_000), &mut defects);
        assert_eq!(faults.pass(response, 0), None);
        // One behind it does not overtake it.
        faults.apply(Change::SdoDelay(0), &mut defects);
        assert_eq!(faults.pass(response, 10_000), None);
        assert_eq!(
            (faults.due(19_999), faults.due(20_000)),
            (None, Some(response))
        );
        assert_eq!(
            (faults.due(20_000), faults.due(20_000)),
            (Some(response), None)
        );
        faults.apply(Change::BusOff(true), &mut defects);
        assert_eq!(faults.pass(boot_up, 0), None);
    }

    /// The frames of an enabled actuator within 200 control periods behind a fault, and behind its
    /// end.
    fn behind(lines: [&str; 2]) -> [Vec<CanFrame>; 2] {
        let mut buffer = vec![0; CAPTURE_VALUES];
        let node = NativeNode::new(1, NodeId::new(1), &Default::default(), &mut buffer);
        let mut bus = Bus::new(vec![node.expect("in range")]);
        let (sender, faults) = mpsc::channel();
        bus.set_faults(faults);
        let mut at_us = 0;
        let mut run = |bus: &mut Bus<'_>, periods| {
            let mut frames = Vec::new();
            for _ in 0..periods {
                at_us += PERIOD_US;
                bus.step(at_us, |_, frame| frames.push(*frame));
            }
            frames
        };
        run(&mut bus, 50);
        let words: [(u16, &[u8]); 4] = [
            (0, &[1, 1]),
            (0x201, &[6, 0]),
            (0x201, &[7, 0]),
            (0x201, &[15, 0]),
        ];
        for (id, data) in words {
            let frame = CanFrame::new(StandardId::new(id).expect("11 bits"), data);
            bus.send(0, frame.expect("8 bytes at most"), |_, _| {});
            run(&mut bus, 5);
        }
        lines.map(|line| {
            sender.send(line.parse().expect("a fault")).expect("a bus");
            run(&mut bus, 200)
        })
    }

    /// The codes of the emergencies among frames.
    fn emergencies(frames: &[CanFrame]) -> Vec<u16> {
        let frames = frames.iter().filter(|frame| frame.raw_id().0 == 0x81);
        let code = |frame: &CanFrame| u16::from_le_bytes([frame.data()[0], frame.data()[1]]);
        frames.map(code).filter(|code| *code != 0).collect()
    }

    #[test]
    fn a_master_sees_each_fault() {
        let [lost, _] = behind(["1 encoder-lost", "1 encoder-back"]);
        assert_eq!(emergencies(&lost)[..1], [0x7306]);
        let [sag, _] = behind(["1 supply 3", "1 supply 6"]);
        assert_eq!(emergencies(&sag), [0x3220]);
        let [off, on] = behind(["1 bus-off", "1 bus-on"]);
        assert!(off.is_empty());
        assert!(
            emergencies(&on).contains(&0x8140),
            "{:x?}",
            emergencies(&on)
        );
        // Of a node that does not exist nothing fails.
        let [other, _] = behind(["2 encoder-lost", "2 jam"]);
        assert!(emergencies(&other).is_empty() && !other.is_empty());
    }
}
