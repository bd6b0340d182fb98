//! The host on the CAN bus: tunes the board, enables it, commands at 50 Hz, and hears telemetry.
//!
//! The chain of the paper, Simulink at 50 Hz, a serial port and a communication board, is not
//! emulated beyond its delay: a command goes on the bus [`CHAIN_MS`] after the host has set it.

use board_tests::frames::{BoardFrame as _, Frame, order};
use virtual_board::can;
use virtual_board::run::{Flow, Script, View};

/// PWM periods, of 1 ms, in a control period.
const PERIODS: u64 = 4;
/// Control periods in a period of the host.
pub const HOST: usize = 5;
/// Time from the host's command to its frame on the bus, ms. The next control step takes it 2 ms
/// later, and 1 ms after that the motor sees it: 17 ms, where the paper matched 17.5 ms by eye.
pub const CHAIN_MS: u64 = 14;
/// From the host's command to the motor, s.
pub const TRUE_DELAY_S: f64 = 0.017;
/// The control period in which the board is enabled.
const ENABLE: u64 = 30;
/// The control period that is time zero: by then the shaft has come to the first command.
const START: u64 = 280;

/// What the board tells of a control period.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Told {
    /// Angle, mdeg.
    pub angle_mdeg: i32,
    /// Rate, 0.1 deg/s.
    pub rate_ddeg_s: i16,
    /// Current, mA.
    pub current_ma: i16,
    /// Duty, 0.01 %.
    pub duty_cpct: i16,
    /// Supply, mV.
    pub supply_mv: u16,
    /// Operating state.
    pub state: u8,
    /// Latched fault, 0 for none.
    pub fault: u8,
}

/// The operating state in which the board moves.
const ENABLED: u8 = 2;

/// The host.
pub struct Host {
    words: Vec<(u8, u32)>,
    /// A command for each of the host's periods, mdeg.
    commands: Vec<i32>,
    period: u64,
    /// Start of the first control period, ns.
    origin_ns: u64,
    told: Vec<Told>,
    refused: Vec<u8>,
}

/// Why a run is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunProblem {
    /// The board refused a parameter.
    #[error("the board refuses parameter {0}")]
    Refused(u8),
    /// The board stopped moving.
    #[error("at {at_s:.3} s the board is in state {state} with fault {fault}")]
    Stopped {
        /// When.
        at_s: f64,
        /// Its state.
        state: u8,
        /// Its fault.
        fault: u8,
    },
    /// Telemetry is missing.
    #[error("{found} control periods were told, expected {expected}")]
    Short {
        /// As many as were heard.
        found: usize,
        /// As many as there were.
        expected: usize,
    },
}

impl Host {
    /// A host that writes these parameters and sends these commands, mdeg, one each 20 ms.
    pub fn new(words: Vec<(u8, u32)>, commands: Vec<i32>) -> Self {
        Self {
            words,
            commands,
            period: 0,
            origin_ns: 0,
            told: Vec::new(),
            refused: Vec::new(),
        }
    }

    /// How long the run takes, ms.
    pub fn duration_ms(&self) -> u64 {
        // A control period more: its telemetry ends in it. The program starts in well below 0.2 s.
        (START + self.samples() as u64 + 2) * PERIODS + 200
    }

    fn samples(&self) -> usize {
        self.commands.len() * HOST
    }

    /// The frame that goes on the bus in the middle of this control period.
    fn frame(&self, tick: u64) -> Option<Frame> {
        let last_ms = tick * PERIODS + PERIODS / 2;
        if tick < ENABLE {
            // One access a control period, and time for its answer.
            let index = (tick / 2) as usize;
            let &(number, value) = self.words.get(index).filter(|_| tick.is_multiple_of(2))?;
            return Some(Frame::write(number, value));
        }
        if tick == ENABLE {
            return Some(Frame::command(0, order::ENABLE));
        }
        let since_ms = (last_ms + 20 * START).checked_sub(START * PERIODS + CHAIN_MS)?;
        if !since_ms.is_multiple_of(20) {
            return None;
        }
        let index = (since_ms / 20).saturating_sub(START) as usize;
        let last = self.commands.last()?;
        Some(Frame::command(
            *self.commands.get(index).unwrap_or(last),
            order::NONE,
        ))
    }

    fn hear(&mut self, at_ns: u64, frame: &can::Frame) {
        let Some(since_ns) = at_ns.checked_sub(self.origin_ns) else {
            return;
        };
        let tick = (since_ns / (PERIODS * 1_000_000)) as usize;
        if self.told.len() <= tick {
            self.told.resize(tick + 1, Told::default());
        }
        let told = &mut self.told[tick];
        let [a, b, c, d, e, f, g, h] = frame.data;
        match frame.id.value() {
            0x181 => {
                told.angle_mdeg = i32::from_le_bytes([a, b, c, d]);
                told.rate_ddeg_s = i16::from_le_bytes([e, f]);
                (told.state, told.fault) = (g, h);
            }
            0x281 => {
                told.current_ma = i16::from_le_bytes([a, b]);
                told.duty_cpct = i16::from_le_bytes([e, f]);
                told.supply_mv = u16::from_le_bytes([g, h]);
            }
            0x381 if a & 0x80 != 0 => self.refused.push(b),
            _ => {}
        }
    }

    /// What was told from time zero on, a row a control period.
    ///
    /// # Errors
    /// [`RunProblem`] of a board that refused, stopped, or fell silent.
    pub fn told(&self) -> Result<&[Told], RunProblem> {
        if let Some(number) = self.refused.first() {
            return Err(RunProblem::Refused(*number));
        }
        let (from, expected) = (START as usize, self.samples());
        let told = self.told.get(from..from + expected);
        let told = told.ok_or(RunProblem::Short {
            found: self.told.len().saturating_sub(from),
            expected,
        })?;
        match told.iter().position(|t| (t.state, t.fault) != (ENABLED, 0)) {
            None => Ok(told),
            Some(index) => Err(RunProblem::Stopped {
                at_s: index as f64 * 0.004,
                state: told[index].state,
                fault: told[index].fault,
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
        let in_the_middle = self.period % PERIODS == PERIODS / 2;
        let frame = in_the_middle
            .then(|| self.frame(self.period / PERIODS))
            .flatten();
        if let Some(port) = view.port(0) {
            if let Some(frame) = frame {
                port.send(now_ns, frame.on_the_wire());
            }
            for (at_ns, frame) in port.take_heard() {
                self.hear(at_ns, &frame);
            }
        }
        self.period += 1;
        Flow::On
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_leave_14_ms_after_the_host_set_them_every_20_ms() {
        let host = Host::new(Vec::new(), vec![1000, 2000, 3000]);
        let sent: Vec<(u64, i32)> = (START..START + 20)
            .filter_map(|tick| {
                let frame = host.frame(tick)?;
                let mdeg = i32::from_le_bytes(frame.on_the_wire().data[..4].try_into().ok()?);
                Some(((tick - START) * 4 + 2, mdeg))
            })
            .collect();
        assert_eq!(sent, [(14, 1000), (34, 2000), (54, 3000), (74, 3000)]);
        // Before it the first command holds the board in time.
        let before = (ENABLE + 1..START).filter(|tick| host.frame(*tick).is_some());
        assert_eq!(before.count(), ((START - ENABLE) as usize) / HOST);
    }
}
