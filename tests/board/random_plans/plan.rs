//! Draws the plans.

use board_tests::frames::{Frame, SAVE, write};
use board_tests::master::{driven, steps};
use rand_pcg::{Pcg32, rand_core::Rng};
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::{EncoderWire, Stuck};

/// The fault begins within this second; the run ends 3 s later.
const FROM_MS: u64 = 2_000;
pub const UNTIL_MS: u64 = 6_000;

const SEED: u64 = 39;

/// The shaft rests at 20 deg, or moves between 20 and -20 deg, or rests while the parameters are
/// saved again and again.
#[derive(Debug, Clone, Copy)]
pub enum State {
    Held,
    Moving,
    Saving,
}

impl State {
    /// The least drift that is detected before the shaft is 5 deg off for half a second, deg/s:
    /// `docs/faults.md`.
    fn least_drift_deg_s(self) -> f64 {
        match self {
            Self::Held | Self::Saving => 4.0,
            Self::Moving => 12.0,
        }
    }

    /// What the master sends.
    pub fn frames(self, tick: u64) -> Vec<Frame> {
        let mut frames = driven(tick, self.target_mdeg(tick));
        if matches!(self, Self::Saving) && tick % 50 == 49 {
            frames.push(write(0x1010, 1, SAVE, 4));
        }
        frames
    }

    fn target_mdeg(self, tick: u64) -> i32 {
        match self {
            Self::Held | Self::Saving => 20_000,
            Self::Moving => steps(tick, 20_000, 125),
        }
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
    let state = match draw.0.next_u32() % 5 {
        0 | 1 => State::Held,
        2 | 3 => State::Moving,
        _ => State::Saving,
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
            // 22 % around the learned constant, and the limit of 2.2 deg in a motion of 27 deg.
            let percent = draw.either(30.0, 60.0);
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
