//! The host on the CAN bus: a CANopen master that sets the board's parameters, enables the drive,
//! sends commands at 50 Hz and records telemetry at 250 Hz.
//!
//! Of the paper's chain, Simulink at 50 Hz, a serial port and a communication board, only the delay
//! is emulated: a command is sent on the bus [`CHAIN_MS`] after the host has set it.

use board_tests::frames::{
    Frame, control, is_operation_enabled, start, to_wire, write, write_real,
};
use board_tests::master::PERIODS;
use canopen::cob_id;
use host_sim::can::client::state_name;
use model_core::time::CONTROL_RATE_HZ;
use virtual_board::can;
use virtual_board::run::{Flow, Script, View};

/// Identifiers of the only node.
const TPDO_1: u32 = cob_id::tpdo(1) + 1;
const TPDO_2: u32 = cob_id::tpdo(2) + 1;
const TPDO_3: u32 = cob_id::tpdo(3) + 1;
const SDO_RESPONSE: u32 = cob_id::SDO_RESPONSE + 1;

/// Control periods in a period of the host.
pub const CONTROL_PERIODS_PER_HOST_PERIOD: usize = 5;
/// Time from the host's command to its frame on the bus, ms. The next control step uses it 4 ms
/// later, and its duty takes effect 1 ms after that: 17 ms in total; the paper matched 17.5 ms
/// visually.
pub const CHAIN_MS: u64 = 12;
/// Delay from the host's command to the motor, s.
pub const TRUE_DELAY_S: f64 = 0.017;
/// The first control period with an SDO request.
const SETUP: u64 = 2;
/// The control period in which the drive is enabled, after the two controlwords in the previous two
/// control periods.
const ENABLE: u64 = 30;
/// The control period of time zero, in which the shaft has reached the first command.
const START: u64 = 280;

/// The time of a sample of the telemetry, s.
pub fn seconds(sample: usize) -> f64 {
    sample as f64 / f64::from(CONTROL_RATE_HZ)
}

/// The sample at a time, s.
pub fn sample_at(time_s: f64) -> usize {
    (time_s * f64::from(CONTROL_RATE_HZ)) as usize
}

/// Telemetry of a control period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sample {
    /// Angle, mdeg.
    pub angle_mdeg: i32,
    /// SampleRate, 0.1 deg/s.
    pub rate_ddeg_s: i16,
    /// Current, mA.
    pub current_ma: i16,
    /// Duty, 0.01 %.
    pub duty_cpct: i16,
    /// Supply, mV.
    pub supply_mv: u32,
    /// Statusword.
    pub statusword: u16,
    /// Error code, 0 for none.
    pub error_code: u16,
}

/// The host.
pub struct Host {
    /// SDO requests, sent one per control period.
    requests: Vec<Frame>,
    /// A command for each of the host's periods, mdeg.
    commands: Vec<i32>,
    period: u64,
    /// Start of the first control period, ns.
    origin_ns: u64,
    samples: Vec<Sample>,
    /// Index and sub-index of the objects that the board refused.
    refused: Vec<(u16, u8)>,
}

/// Reason why a run is not usable.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HostError {
    /// The board refused the value of an object.
    #[error("the board refuses {index:04X}h:{sub}")]
    Refused {
        /// Index of the object.
        index: u16,
        /// Sub-index.
        sub: u8,
    },
    /// The drive left OPERATION ENABLED or reported an error.
    #[error("at {at_s:.3} s the drive is in state `{state}` with error code {error_code:04X}h")]
    Stopped {
        /// Time, s.
        at_s: f64,
        /// Its state.
        state: &'static str,
        /// Its error code.
        error_code: u16,
    },
    /// Telemetry is missing.
    #[error("telemetry has {found} control periods, expected {expected}")]
    Short {
        /// Control periods with telemetry.
        found: usize,
        /// Control periods of the run.
        expected: usize,
    },
}

/// Maps objects, each with its length in bits, into TPDO 1 or 2.
fn map(pdo: u8, objects: &[u32]) -> Vec<Frame> {
    let (parameter, mapping) = (0x1800 + u16::from(pdo) - 1, 0x1A00 + u16::from(pdo) - 1);
    let cob_id = 0x4000_0081 + 0x100 * u32::from(pdo);
    let mut requests = vec![
        write(parameter, 1, 0x8000_0000 | cob_id, 4),
        write(mapping, 0, 0, 1),
    ];
    for (sub, object) in (1..).zip(objects) {
        requests.push(write(mapping, sub, *object, 4));
    }
    requests.push(write(mapping, 0, objects.len() as u32, 1));
    requests.push(write(parameter, 1, cob_id, 4));
    requests
}

/// Settings that the host makes before it enables the drive: commands without interpolation in the
/// full range, telemetry in each control period, and these gains.
fn setup(gains: &[((u16, u8), f64)]) -> Vec<Frame> {
    let mut requests = vec![
        write(0x607D, 1, -180_000_i32 as u32, 4),
        write(0x607D, 2, 180_000, 4),
        // 60C2h: 4 ms, so that a command is not spread over several control periods.
        write(0x60C2, 1, 4, 1),
        write(0x1802, 5, 4, 2),
    ];
    // Angle and rate; current, duty and supply. TPDO 3 has statusword, mode and error code.
    requests.extend(map(1, &[0x6064_0020, 0x2008_0210]));
    requests.extend(map(2, &[0x2004_0010, 0x2002_0010, 0x6079_0020]));
    let gains = gains.iter();
    requests.extend(gains.map(|((index, sub), value)| write_real(*index, *sub, *value as f32)));
    requests
}

impl Host {
    /// A host that sets these gains, by their objects, and sends these commands, mdeg, one per
    /// 20 ms.
    pub fn new(gains: &[((u16, u8), f64)], commands: Vec<i32>) -> Self {
        Self {
            requests: setup(gains),
            commands,
            period: 0,
            origin_ns: 0,
            samples: Vec::new(),
            refused: Vec::new(),
        }
    }

    /// How long the run takes, ms.
    pub fn duration_ms(&self) -> u64 {
        // With the control period in which the last telemetry ends. The program starts in well
        // below 0.2 s.
        (START + self.expected() as u64 + 2) * PERIODS + 200
    }

    /// Control periods of the run.
    fn expected(&self) -> usize {
        self.commands.len() * CONTROL_PERIODS_PER_HOST_PERIOD
    }

    /// The frame that is sent at the start of this control period; the next control step uses it.
    fn frame(&self, tick: u64) -> Option<Frame> {
        match tick {
            ..SETUP => None,
            _ if tick < ENABLE - 3 => self.requests.get((tick - SETUP) as usize).copied(),
            _ if tick == ENABLE - 3 => Some(start()),
            _ if tick == ENABLE - 2 => Some(control(0x06, 0)),
            _ if tick == ENABLE - 1 => Some(control(0x07, 0)),
            _ if tick == ENABLE => Some(control(0x0f, 0)),
            _ => self.command(tick),
        }
    }

    fn command(&self, tick: u64) -> Option<Frame> {
        let since_ms = (tick * PERIODS + 20 * START).checked_sub(START * PERIODS + CHAIN_MS)?;
        if !since_ms.is_multiple_of(20) {
            return None;
        }
        let index = (since_ms / 20).saturating_sub(START) as usize;
        let last = self.commands.last()?;
        Some(control(0x0f, *self.commands.get(index).unwrap_or(last)))
    }

    fn receive(&mut self, at_ns: u64, frame: &can::Frame) {
        let Some(since_ns) = at_ns.checked_sub(self.origin_ns) else {
            return;
        };
        let tick = (since_ns / (PERIODS * 1_000_000)) as usize;
        if self.samples.len() <= tick {
            self.samples.resize(tick + 1, Sample::default());
        }
        let sample = &mut self.samples[tick];
        let [a, b, c, d, e, f, g, h] = frame.data;
        match frame.id.value() {
            TPDO_1 => {
                sample.angle_mdeg = i32::from_le_bytes([a, b, c, d]);
                sample.rate_ddeg_s = i16::from_le_bytes([e, f]);
            }
            TPDO_2 => {
                sample.current_ma = i16::from_le_bytes([a, b]);
                sample.duty_cpct = i16::from_le_bytes([c, d]);
                sample.supply_mv = u32::from_le_bytes([e, f, g, h]);
            }
            TPDO_3 => {
                sample.statusword = u16::from_le_bytes([a, b]);
                sample.error_code = u16::from_le_bytes([d, e]);
            }
            SDO_RESPONSE if a == 0x80 => self.refused.push((u16::from_le_bytes([b, c]), d)),
            _ => {}
        }
    }

    /// Telemetry from time zero on, one row per control period.
    ///
    /// # Errors
    /// [`HostError`] if the board refused an object, left OPERATION ENABLED, or sent no telemetry.
    pub fn samples(&self) -> Result<&[Sample], HostError> {
        if let Some(&(index, sub)) = self.refused.first() {
            return Err(HostError::Refused { index, sub });
        }
        let (from, expected) = (START as usize, self.expected());
        let samples = self.samples.get(from..from + expected);
        let samples = samples.ok_or(HostError::Short {
            found: self.samples.len().saturating_sub(from),
            expected,
        })?;
        let runs =
            |sample: &Sample| is_operation_enabled(sample.statusword) && sample.error_code == 0;
        match samples.iter().position(|sample| !runs(sample)) {
            None => Ok(samples),
            Some(index) => Err(HostError::Stopped {
                at_s: seconds(index),
                state: state_name(samples[index].statusword),
                error_code: samples[index].error_code,
            }),
        }
    }
}

impl Script for Host {
    fn at_edge(&mut self, view: &mut View<'_>) -> Flow {
        if self.period == 0 {
            self.origin_ns = view.row.at_ns;
        }
        let now_ns = view.now_ns();
        let is_start = self.period.is_multiple_of(PERIODS);
        let frame = is_start
            .then(|| self.frame(self.period / PERIODS))
            .flatten();
        if let Some(port) = view.port(0) {
            if let Some(frame) = frame {
                port.send(now_ns, to_wire(&frame));
            }
            for (at_ns, frame) in port.take_received() {
                self.receive(at_ns, &frame);
            }
        }
        self.period += 1;
        Flow::Continue
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_sent_every_20_ms_12_ms_after_the_host_has_set_them() {
        let host = Host::new(&[], vec![1000, 2000, 3000]);
        let sent: Vec<(u64, i32)> = (START..START + 20)
            .filter_map(|tick| {
                let [_, _, a, b, c, d, ..] = host.frame(tick)?.bytes();
                Some(((tick - START) * 4, i32::from_le_bytes([a, b, c, d])))
            })
            .collect();
        assert_eq!(sent, [(12, 1000), (32, 2000), (52, 3000), (72, 3000)]);
        // Before time zero the first command is repeated, which prevents a command timeout.
        let before = (ENABLE + 1..START).filter(|tick| host.frame(*tick).is_some());
        assert_eq!(
            before.count(),
            ((START - ENABLE) as usize) / CONTROL_PERIODS_PER_HOST_PERIOD
        );
    }

    #[test]
    fn the_requests_fit_before_the_node_is_started() {
        let requests = setup(&crate::test_bench::Controller::Retuned.objects());
        assert!(
            SETUP + requests.len() as u64 <= ENABLE - 3,
            "{}",
            requests.len()
        );
    }
}
