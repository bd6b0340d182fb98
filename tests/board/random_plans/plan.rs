//! Draws the plans.

use board_tests::frames::{Frame, SAVE, control, mode, start, velocity, write};
use board_tests::master::{ENABLED_TICK, driven, steps};
use rand_pcg::{Pcg32, rand_core::Rng};
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::{EncoderWire, Stuck};

/// The fault begins within this second; the run ends 3 s later.
const FROM_MS: u64 = 2_000;
pub const UNTIL_MS: u64 = 6_000;

const SEED: u64 = 39;

/// What the drive does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It rests at 20 deg.
    Held,
    /// It moves between 20 and -20 deg.
    Moving,
    /// It rests while the parameters are saved again and again.
    Saving,
    /// The same motion by set-points of the profile position mode.
    Profile,
    /// 40 and -40 deg/s, alternating twice a second.
    Velocity,
    /// It searches the lower mechanical stop at 25 deg/s.
    Homing,
    /// 15 and -15 % of the rated torque, alternating twice a second.
    Torque,
}

impl State {
    /// The least drift that is detected before the shaft is 5 deg off for half a second, deg/s:
    /// `docs/faults.md`.
    fn least_drift_deg_s(self) -> f64 {
        match self {
            Self::Held | Self::Saving => 4.0,
            // In a motion in one direction the tolerance is 45 % of 25 deg/s.
            Self::Homing => 20.0,
            _ => 12.0,
        }
    }

    /// The least scale that is detected, %: until the first motion to and fro the encoder may show
    /// 25 % less than the back-EMF, and 45 % more. Then it is 22 % around the learned constant, and
    /// 2.2 deg in a motion of 27 deg.
    fn least_scale_pct(self) -> f64 {
        match self {
            Self::Homing => 75.0,
            _ => 30.0,
        }
    }

    fn greatest_scale_pct(self) -> f64 {
        match self {
            Self::Homing => 100.0,
            _ => 60.0,
        }
    }

    /// What the master sends.
    pub fn frames(self, tick: u64) -> Vec<Frame> {
        match self {
            Self::Held => driven(tick, 20_000),
            Self::Moving => driven(tick, steps(tick, 20_000, 125)),
            Self::Saving => {
                let mut frames = driven(tick, 20_000);
                let saves = tick % 50 == 49;
                frames.extend(saves.then(|| write(0x1010, 1, SAVE, 4)));
                frames
            }
            Self::Profile => in_mode(1, tick, |since| {
                // A set-point at each edge of bit 4.
                let word = if since % 125 < 60 { 0x3f } else { 0x2f };
                control(word, steps(since, 20_000, 125))
            }),
            Self::Velocity => in_mode(3, tick, |since| velocity(0x0f, steps(since, 40_000, 125))),
            Self::Homing => match tick {
                // On the lower stop, by the current.
                22 => vec![write(0x6098, 0, -3_i32 as u32, 1)],
                24 => vec![write(0x6099, 1, 25_000, 4)],
                _ => in_mode(6, tick, |_| control(0x1f, 0)),
            },
            Self::Torque => in_mode(10, tick, |since| {
                let torque = steps(since, 150, 125) as u16;
                write(0x6071, 0, torque.into(), 2)
            }),
        }
    }
}

/// Enables a drive in this mode, and sends a command each fifth tick.
fn in_mode(code: i8, tick: u64, command: impl FnOnce(u64) -> Frame) -> Vec<Frame> {
    match tick {
        20 => vec![start()],
        30 => vec![mode(0x06, code)],
        32 => vec![mode(0x07, code)],
        34 => vec![mode(0x0f, code)],
        ENABLED_TICK.. if tick.is_multiple_of(5) => vec![command(tick - ENABLED_TICK)],
        _ => Vec::new(),
    }
}

/// Numbers of a plan.
pub struct Draw(Pcg32);

impl Draw {
    /// Between both, uniformly.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / 4_294_967_296.0
    }

    /// The same with either sign.
    fn either(&mut self, low: f64, high: f64) -> f64 {
        let magnitude = self.between(low, high);
        if self.0.next_u32().is_multiple_of(2) {
            magnitude
        } else {
            -magnitude
        }
    }

    fn ms(&mut self, low: u64, high: u64) -> u64 {
        self.between(low as f64, high as f64) as u64
    }
}

/// A fault that comes and goes from this instant on.
fn intermittent(draw: &mut Draw, from_ms: u64, fault: &Fault) -> Vec<Planned> {
    let period_ms = draw.ms(8, 200);
    let on_ms = (period_ms as f64 * draw.between(0.3, 0.95)) as u64;
    (from_ms..UNTIL_MS)
        .step_by(period_ms as usize)
        .map(|ms| Planned::at_ms(ms, fault.clone()).for_ms(on_ms.max(1)))
        .collect()
}

/// A magnet that drifts at this rate, deg/s, in steps of a control period.
fn drift(from_ms: u64, rate_deg_s: f64) -> Vec<Planned> {
    let slip = |period: u64| {
        let deg = rate_deg_s * (period + 1) as f64 * 0.004;
        let slip = Planned::at_ms(from_ms + 4 * period, Fault::MagnetSlips { deg });
        Planned {
            for_ns: Some(3_990_000),
            ..slip
        }
    };
    (0..(UNTIL_MS - from_ms) / 4).map(slip).collect()
}

/// A plan: what the shaft and the board bear, and what the sensors show.
pub struct Plan {
    pub kind: &'static str,
    pub loads: Vec<Planned>,
    pub sensors: Vec<Planned>,
}

/// The plan with this number, and the state in which the drive is.
pub fn draw(number: u64) -> (State, Plan) {
    let mut draw = Draw(Pcg32::new(SEED, number));
    let state = match draw.0.next_u32() % 10 {
        0..=2 => State::Held,
        3 | 4 => State::Moving,
        5 => State::Saving,
        6 => State::Profile,
        7 => State::Velocity,
        8 => State::Homing,
        _ => State::Torque,
    };
    let plan = plan(&mut draw, state);
    (state, plan)
}

fn plan(draw: &mut Draw, state: State) -> Plan {
    let from_ms = FROM_MS + draw.ms(0, 1_000);
    let at = |fault| vec![Planned::at_ms(from_ms, fault)];
    let cut = Fault::EncoderWire {
        line: EncoderWire::Data,
        stuck: Stuck::Low,
    };
    let load = |nm| vec![Planned::at_ms(1_500, Fault::Torque { nm })];
    let flicker = Fault::EncoderBits { mask: 0b100_0001 };
    let lie = |kind, sensors| Plan {
        kind,
        loads: Vec::new(),
        sensors,
    };
    let bear = |kind, loads| Plan {
        kind,
        loads,
        sensors: Vec::new(),
    };
    match draw.0.next_u32() % 16 {
        0 => lie(
            "drift",
            drift(from_ms, draw.either(state.least_drift_deg_s(), 100.0)),
        ),
        1 => {
            let deg = draw.either(2.0, 45.0);
            lie("slip", at(Fault::MagnetSlips { deg }))
        }
        2 => {
            let gap = Planned::at_ms(from_ms, cut).for_ms(draw.ms(4, 14));
            let deg = draw.either(2.0, 45.0);
            let slip = Planned::at_ms(from_ms + 2, Fault::MagnetSlips { deg });
            lie("slip in a gap", vec![gap, slip])
        }
        3 => lie("frozen", at(Fault::EncoderFrozen)),
        4 => {
            let mut sensors = at(Fault::EncoderFrozen);
            sensors.extend(intermittent(draw, from_ms, &flicker));
            lie("frozen and flickering", sensors)
        }
        5 => lie("words that come and go", intermittent(draw, from_ms, &cut)),
        6 => {
            let nm = draw.either(0.1, 0.8);
            bear("load", at(Fault::Torque { nm }))
        }
        7 => Plan {
            kind: "frozen under a load",
            loads: load(draw.either(0.1, 0.8)),
            sensors: at(Fault::EncoderFrozen),
        },
        8 => {
            let ohm = draw.between(1.0, 3.0);
            let mut loads = load(draw.either(0.1, 0.5));
            loads.extend(at(Fault::Source { ohm }));
            bear("soft supply under a load", loads)
        }
        9 => {
            let volts = draw.between(3.7, 3.95);
            let supply = intermittent(draw, from_ms, &Fault::Supply { volts });
            bear("supply that comes and goes", supply)
        }
        10 => bear(
            "jam that comes and goes",
            intermittent(draw, from_ms, &Fault::Jam),
        ),
        11 => {
            let code = draw.between(0.0, 4096.0) as u16;
            Plan {
                kind: "current sense that is stuck",
                loads: load(draw.either(0.0, 0.5)),
                sensors: at(Fault::CurrentSense { code }),
            }
        }
        12 => {
            let percent = draw.either(state.least_scale_pct(), state.greatest_scale_pct());
            lie("scale", at(Fault::EncoderScale { percent }))
        }
        13 => {
            let deg = draw.between(0.0, 8.0);
            lie("play", at(Fault::EncoderPlay { deg }))
        }
        14 => {
            let percent = draw.between(-100.0, 100.0);
            Plan {
                kind: "gain of the current sense",
                loads: load(draw.either(0.0, 0.5)),
                sensors: at(Fault::CurrentGain { percent }),
            }
        }
        _ => Plan {
            kind: "drift under a load",
            loads: load(draw.either(0.1, 0.8)),
            sensors: drift(from_ms, draw.either(state.least_drift_deg_s(), 100.0)),
        },
    }
}
