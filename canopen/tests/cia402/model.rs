//! A model of the state machine, the modes, the set-points and the limits, written from the tables
//! of CiA 402, beside the axis over 100,000 random operations with a seed.

use canopen::cia402::{
    Cia402State, Deceleration, Demand, Fault, HomingMethod, Mode, Options, Output, QuickStop,
    StopOption, controlword, statusword,
};

use crate::Bench;

const OPERATIONS: u32 = 100_000;
/// Every mode, and none.
pub const MODES: [Mode; 9] = [
    Mode::None,
    Mode::ProfilePosition,
    Mode::ProfileVelocity,
    Mode::Homing,
    Mode::InterpolatedPosition,
    Mode::CyclicPosition,
    Mode::CyclicVelocity,
    Mode::ProfileTorque,
    Mode::CyclicTorque,
];

/// A linear congruential generator.
struct Random(u64);

impl Random {
    fn below(&mut self, end: u32) -> u32 {
        self.0 = (self.0.wrapping_mul(6_364_136_223_846_793_005)).wrapping_add(1);
        (((self.0 >> 32) * u64::from(end)) >> 32) as u32
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u32) as usize]
    }
}

/// Commands of the controlword: mask and value, as in the standard's table.
const COMMANDS: [(u16, u16, char); 5] = [
    (0x02, 0x00, 'v'),
    (0x06, 0x02, 'q'),
    (0x07, 0x06, 's'),
    (0x0F, 0x07, 'o'),
    (0x0F, 0x0F, 'e'),
];

/// What the drive does in a period.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Action {
    Off,
    Stop(Deceleration),
    Run,
}

/// The state that the standard prescribes.
struct Model {
    state: Cia402State,
    command: char,
    reset: bool,
    reaction: Option<Deceleration>,
    mode: Option<Mode>,
    bit_4: bool,
    /// Profile position: the targets that are in progress, the active one first.
    targets: Vec<i32>,
    /// The active target, or the one that was reached last.
    last: Option<i32>,
    /// The active target ends in this period: bit 10 was shown.
    is_arrived: bool,
    acknowledge: bool,
    /// Periods since the active target began, without a stop.
    age: u32,
}

impl Model {
    /// The state and the action of a period; `at_rest` is the motor before it.
    fn transit(&mut self, word: u16, fault: Fault, at_rest: bool, o: &Options) -> Action {
        use Cia402State::{
            Fault as Faulty, FaultReactionActive, NotReadyToSwitchOn, OperationEnabled,
            QuickStopActive, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn,
        };
        let command = COMMANDS
            .iter()
            .find(|(mask, value, _)| word & mask == *value);
        let command = command.expect("the table is complete").2;
        let reset = word & 0x80 != 0;
        let resets = !core::mem::replace(&mut self.reset, reset) && reset;
        if !reset || matches!(command, 'v' | 'q') {
            self.command = command;
        }
        let powered = matches!(self.state, OperationEnabled | QuickStopActive);
        if fault != Fault::None && !matches!(self.state, FaultReactionActive | Faulty) {
            self.state = FaultReactionActive;
            self.reaction = match o.fault_reaction {
                StopOption::Stop(how) if powered && fault == Fault::Controlled => Some(how),
                _ => None,
            };
            return self.reaction.map_or(Action::Off, Action::Stop);
        }
        let (next, action) = match (self.state, self.command) {
            (NotReadyToSwitchOn, _) => (SwitchOnDisabled, Action::Off),
            (SwitchOnDisabled, 's') => (ReadyToSwitchOn, Action::Off),
            (ReadyToSwitchOn, 'o') => (SwitchedOn, Action::Off),
            (ReadyToSwitchOn | SwitchedOn, 'e') => (OperationEnabled, Action::Run),
            (SwitchedOn, 's') => (ReadyToSwitchOn, Action::Off),
            (ReadyToSwitchOn | SwitchedOn, 'v' | 'q') => (SwitchOnDisabled, Action::Off),
            (Faulty, _) if resets && fault == Fault::None => {
                // A command has bit 7 clear: none of before the reset acts behind it.
                self.command = 'v';
                (SwitchOnDisabled, Action::Off)
            }
            (FaultReactionActive, _) => match self.reaction {
                Some(how) if !at_rest && fault != Fault::Immediate => {
                    (FaultReactionActive, Action::Stop(how))
                }
                _ => (Faulty, Action::Off),
            },
            (OperationEnabled, 'e') if word & 0x100 == 0 => (OperationEnabled, Action::Run),
            (OperationEnabled, 'e') => match o.halt {
                StopOption::Stop(how) => (OperationEnabled, Action::Stop(how)),
                StopOption::Disable => (OperationEnabled, Action::Stop(Deceleration::SlowDown)),
            },
            (OperationEnabled, 'o') => ends(o.disable_operation, at_rest, SwitchedOn),
            (OperationEnabled, 's') => ends(o.shutdown, at_rest, ReadyToSwitchOn),
            (OperationEnabled, 'v') => (SwitchOnDisabled, Action::Off),
            (OperationEnabled, _) => self.quick_stop(o.quick_stop, at_rest),
            (QuickStopActive, _) => self.quick_stop(o.quick_stop, at_rest),
            (same, _) => (same, Action::Off),
        };
        self.state = next;
        action
    }

    fn quick_stop(&self, option: QuickStop, at_rest: bool) -> (Cia402State, Action) {
        use Cia402State::{OperationEnabled, QuickStopActive, SwitchOnDisabled};
        match (self.command, option.stop) {
            ('e', _) if option.remains_active => (OperationEnabled, Action::Run),
            ('v', _) | (_, StopOption::Disable) => (SwitchOnDisabled, Action::Off),
            (_, StopOption::Stop(_)) if at_rest && !option.remains_active => {
                (SwitchOnDisabled, Action::Off)
            }
            (_, StopOption::Stop(how)) => (QuickStopActive, Action::Stop(how)),
        }
    }

    /// The set-points of a period in profile position mode.
    fn set_points(&mut self, bench: &Bench, action: Action) {
        let word = bench.input.controlword;
        let bit_4 = word & controlword::NEW_SET_POINT != 0;
        if action != Action::Run {
            (self.age, self.is_arrived) = (0, false);
            let is_halt = self.state == Cia402State::OperationEnabled && action != Action::Off;
            if !is_halt {
                self.mode = None;
            }
            return;
        }
        self.age += 1;
        let starts = self.mode.replace(bench.input.mode) != Some(bench.input.mode);
        let rises = !core::mem::replace(&mut self.bit_4, bit_4) && bit_4;
        if starts {
            (self.targets, self.last, self.acknowledge) = (Vec::new(), None, false);
        }
        if bench.input.mode != Mode::ProfilePosition {
            return;
        }
        if rises && !starts {
            let target = bench.input.target_position;
            if word & controlword::CHANGE_SET_IMMEDIATELY != 0 || self.targets.is_empty() {
                (self.targets, self.last, self.age) = (vec![target], Some(target), 0);
                (self.acknowledge, self.is_arrived) = (true, false);
            } else if self.targets.len() < 2 {
                self.targets.push(target);
                self.acknowledge = true;
            }
        }
        if !bit_4 && self.targets.len() < 2 {
            self.acknowledge = false;
        }
        if core::mem::take(&mut self.is_arrived) {
            self.targets.remove(0);
            if let Some(next) = self.targets.first() {
                (self.last, self.age) = (Some(*next), 0);
            }
        }
    }

    /// The end of a motion, which bit 10 shows.
    fn reached(&mut self, bench: &Bench, output: &Output) {
        let Some(last) = self.last else { return };
        let (low, high) = bench.parameters.position_limits.expect("limits");
        let target = last.clamp(low, high);
        let is_reached = output.statusword & statusword::TARGET_REACHED != 0;
        // 120 deg at 300 deg/s with ramps of 0.1 s, a reversal before, and 20 ms in the window.
        assert!(is_reached || self.age < 200, "{target} is not reached");
        let off = bench.input.position_actual.abs_diff(target);
        assert!(!is_reached || off <= 500, "{off}");
        self.is_arrived = is_reached && !self.targets.is_empty();
    }
}

fn ends(option: StopOption, at_rest: bool, next: Cia402State) -> (Cia402State, Action) {
    match option {
        StopOption::Stop(how) if !at_rest => (Cia402State::OperationEnabled, Action::Stop(how)),
        _ => (next, Action::Off),
    }
}

/// Changes something that a master, the motor or the option codes may change.
fn operate(random: &mut Random, bench: &mut Bench, is_off: bool) {
    let input = &mut bench.input;
    match random.below(16) {
        0..=5 => {
            let words = [0x06, 0x07, 0x0F, 0x0F, 0x0F, 0x02, 0x00, 0x80, 0x10F, 0x8F];
            let bits = random.one_of(&[0, 0, 0x10, 0x30]);
            input.controlword = random.one_of(&words) | bits;
        }
        6 | 7 => input.controlword ^= 0x10,
        8 => input.mode = random.one_of(&MODES),
        9 | 10 => input.target_position = random.below(160_000) as i32 - 80_000,
        11 => {
            input.target_velocity = random.below(1_200_000) as i32 - 600_000;
            input.target_torque = random.below(4_000) as i16 - 2_000;
        }
        12 => input.fault = random.one_of(&[Fault::None, Fault::Controlled, Fault::Immediate]),
        13..=14 => input.fault = Fault::None,
        // Until the mode is not powered, its options are locked.
        _ if is_off => {
            let stop = |code| StopOption::from_code(code).expect("a code");
            bench.parameters.options = Options {
                quick_stop: QuickStop::from_code(random.below(9) as i16).expect("a code"),
                shutdown: stop(random.below(2) as i16),
                disable_operation: stop(random.below(2) as i16),
                halt: stop(1 + random.below(3) as i16),
                fault_reaction: stop(random.below(4) as i16),
            };
        }
        _ => {}
    }
}

/// Position and velocity demands of a period after another one. A torque demands the velocity that
/// the motor has.
fn check_limits(
    bench: &Bench,
    (action, actual): (Action, i32),
    before: (i32, i32),
    output: &Output,
) -> (i32, i32) {
    let parameters = &bench.parameters;
    let (low, high) = parameters.position_limits.expect("limits");
    let (position, velocity) = match output.demand {
        Demand::Off => return (bench.input.position_actual, 0),
        Demand::Position { position, velocity } => (position, velocity),
        Demand::Velocity(velocity) => (bench.input.position_actual, velocity),
        Demand::Torque { .. } => (bench.input.position_actual, actual),
    };
    assert!(
        velocity.unsigned_abs() <= parameters.max_velocity,
        "{velocity}"
    );
    // A motion that a stop or another mode decelerates may end beyond a limit; nothing accelerates
    // there, or goes on.
    let outward = match position {
        _ if position > high => 1,
        _ if position < low => -1,
        _ => 0,
    };
    let (now, then) = (velocity * outward, before.1 * outward);
    assert!(now <= then.max(0), "{position}: {then} to {now}");
    let change = velocity.abs_diff(before.1);
    let fastest_stop = matches!(action, Action::Stop(Deceleration::Limit));
    let is_profile = matches!(
        bench.input.mode,
        Mode::ProfilePosition | Mode::ProfileVelocity
    );
    // A motion of another mode may reach a position limit faster than the ramp decelerates.
    let is_limited = output.statusword & statusword::INTERNAL_LIMIT != 0;
    let ends_at_limit = is_limited && velocity.abs() < before.1.abs();
    if is_profile && !fastest_stop && !ends_at_limit {
        // 6000 deg/s^2 in 4 ms.
        assert!(change <= 24_000, "{change} at {velocity}, {action:?}");
    }
    (position, velocity)
}

#[test]
fn a_model_of_the_standard_agrees_over_100_000_operations() {
    let mut random = Random(402);
    let mut bench = Bench::new(Mode::ProfilePosition);
    bench.parameters.homing.method = HomingMethod::None;
    let mut model = Model {
        state: Cia402State::NotReadyToSwitchOn,
        command: 'v',
        reset: false,
        reaction: None,
        mode: None,
        bit_4: false,
        targets: Vec::new(),
        last: None,
        is_arrived: false,
        acknowledge: false,
        age: 0,
    };
    let (mut demand, mut seen) = ((0, 0), std::collections::HashMap::new());
    for operation in 0..OPERATIONS {
        operate(
            &mut random,
            &mut bench,
            demand.1 == 0 && model.command != 'e',
        );
        for _ in 0..random.one_of(&[1, 2, 5, 60]) {
            let slow = bench.input.velocity_actual.unsigned_abs() <= 500;
            let input = bench.input;
            let action = model.transit(
                input.controlword,
                input.fault,
                demand.1 == 0 && slow,
                &bench.parameters.options,
            );
            model.set_points(&bench, action);
            let output = bench.step();
            let at = format!("operation {operation}, {:?}, {action:?}", input.mode);
            assert_eq!(output.state, model.state, "{at}");
            let powered = action != Action::Off;
            assert_eq!(output.demand != Demand::Off, powered, "{at}");
            let bit_12 = output.statusword & statusword::MODE_12 != 0;
            if input.mode == Mode::ProfilePosition {
                let acknowledges = action == Action::Run && model.acknowledge;
                assert_eq!(bit_12, acknowledges, "{at}");
            }
            if action == Action::Run && input.mode == Mode::ProfilePosition {
                model.reached(&bench, &output);
            }
            demand = check_limits(&bench, (action, input.velocity_actual), demand, &output);
            *seen.entry((model.state, input.mode)).or_insert(0_u32) += 1;
        }
    }
    // Each mode was operated, stopped quickly, and had faults.
    for mode in MODES {
        for state in [
            Cia402State::OperationEnabled,
            Cia402State::QuickStopActive,
            Cia402State::FaultReactionActive,
        ] {
            assert!(seen.get(&(state, mode)) > Some(&50), "{state:?} {mode:?}");
        }
    }
}
