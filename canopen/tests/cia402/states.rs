use canopen::cia402::{
    Conditions, Deceleration, Fault, Mode, Motion, Options, QuickStop, State, StateMachine,
    StopOption,
};

use crate::{Bench, machine};

const SHUTDOWN: u16 = 0x06;
const SWITCH_ON: u16 = 0x07;
const ENABLE: u16 = 0x0F;
const DISABLE_VOLTAGE: u16 = 0x00;
const QUICK_STOP: u16 = 0x02;
const FAULT_RESET: u16 = 0x80;

const READY: Conditions = Conditions {
    initialised: true,
    voltage: true,
    fault: Fault::None,
    standstill: true,
};

/// A machine in a state, by the shortest way.
fn in_state(state: State) -> StateMachine {
    let options = options();
    let mut machine = machine();
    let way: &[u16] = match state {
        State::NotReadyToSwitchOn => &[],
        State::SwitchOnDisabled => &[0],
        State::ReadyToSwitchOn => &[0, SHUTDOWN],
        State::SwitchedOn => &[0, SHUTDOWN, SWITCH_ON],
        State::OperationEnabled => &[0, SHUTDOWN, SWITCH_ON, ENABLE],
        State::QuickStopActive => &[0, SHUTDOWN, SWITCH_ON, ENABLE, QUICK_STOP],
        State::FaultReactionActive | State::Fault => &[0, SHUTDOWN, SWITCH_ON, ENABLE],
    };
    for word in way {
        machine.step(*word, READY, &options);
    }
    if matches!(state, State::FaultReactionActive | State::Fault) {
        let fault = Conditions {
            fault: Fault::Controlled,
            standstill: false,
            ..READY
        };
        machine.step(ENABLE, fault, &options);
        if state == State::Fault {
            machine.step(ENABLE, READY, &options);
        }
    }
    assert_eq!(machine.state(), state);
    machine
}

/// A quick stop that stays, so that transition 16 exists.
fn options() -> Options {
    let stop = StopOption::Stop(Deceleration::QuickStop);
    Options {
        quick_stop: QuickStop { stop, stays: true },
        ..Options::default()
    }
}

#[test]
fn every_state_and_command_leads_where_the_standard_says() {
    use State::{
        Fault as Faulty, FaultReactionActive as Reacting, NotReadyToSwitchOn as NotReady,
        OperationEnabled as Enabled, QuickStopActive as Quick, ReadyToSwitchOn as Rtso,
        SwitchOnDisabled as Sod, SwitchedOn as On,
    };
    // Shutdown, switch on, enable operation, disable voltage, quick stop, fault reset; the rest stay.
    let words = [
        SHUTDOWN,
        SWITCH_ON,
        ENABLE,
        DISABLE_VOLTAGE,
        QUICK_STOP,
        FAULT_RESET,
    ];
    let table = [
        (NotReady, [Sod, Sod, Sod, Sod, Sod, Sod]),
        (Sod, [Rtso, Sod, Sod, Sod, Sod, Sod]),
        (Rtso, [Rtso, On, On, Sod, Sod, Sod]),
        (On, [Rtso, On, Enabled, Sod, Sod, Sod]),
        (Enabled, [Rtso, On, Enabled, Sod, Quick, Sod]),
        (Quick, [Quick, Quick, Enabled, Sod, Quick, Sod]),
        (Reacting, [Faulty, Faulty, Faulty, Faulty, Faulty, Faulty]),
        (Faulty, [Faulty, Faulty, Faulty, Faulty, Faulty, Sod]),
    ];
    for (from, expected) in table {
        for (word, to) in words.into_iter().zip(expected) {
            let mut machine = in_state(from);
            machine.step(word, READY, &options());
            assert_eq!(machine.state(), to, "{from:?} by {word:#06X}");
        }
    }
}

#[test]
fn a_fault_leads_from_every_state_to_fault() {
    for state in [
        State::NotReadyToSwitchOn,
        State::SwitchOnDisabled,
        State::ReadyToSwitchOn,
        State::SwitchedOn,
        State::OperationEnabled,
        State::QuickStopActive,
    ] {
        for fault in [Fault::Controlled, Fault::Immediate] {
            let mut machine = in_state(state);
            let conditions = Conditions { fault, ..READY };
            machine.step(ENABLE, conditions, &options());
            assert_eq!(machine.state(), State::FaultReactionActive, "{state:?}");
            machine.step(ENABLE, conditions, &options());
            assert_eq!(machine.state(), State::Fault, "{state:?}");
        }
    }
}

#[test]
fn a_fault_is_reset_by_a_rising_edge_once_its_cause_is_gone() {
    let mut machine = in_state(State::Fault);
    let faulty = Conditions {
        fault: Fault::Controlled,
        ..READY
    };
    machine.step(FAULT_RESET, faulty, &options());
    machine.step(FAULT_RESET, READY, &options());
    assert_eq!(machine.state(), State::Fault, "the edge was too early");
    machine.step(0, READY, &options());
    machine.step(FAULT_RESET, READY, &options());
    assert_eq!(machine.state(), State::SwitchOnDisabled);
}

#[test]
fn power_needs_initialisation_and_voltage() {
    let mut machine = machine();
    machine.step(
        SHUTDOWN,
        Conditions {
            initialised: false,
            ..READY
        },
        &options(),
    );
    assert_eq!(machine.state(), State::NotReadyToSwitchOn);
    let mut machine = in_state(State::ReadyToSwitchOn);
    machine.step(
        SWITCH_ON,
        Conditions {
            voltage: false,
            ..READY
        },
        &options(),
    );
    assert_eq!(machine.state(), State::ReadyToSwitchOn);
}

#[test]
fn only_powered_states_move() {
    for (state, moves) in [
        (State::SwitchOnDisabled, false),
        (State::ReadyToSwitchOn, false),
        (State::SwitchedOn, false),
        (State::OperationEnabled, true),
        (State::QuickStopActive, true),
        (State::FaultReactionActive, true),
        (State::Fault, false),
    ] {
        let word = match state {
            State::OperationEnabled => ENABLE,
            State::SwitchedOn => SWITCH_ON,
            State::QuickStopActive => QUICK_STOP,
            _ => SHUTDOWN,
        };
        let moving = Conditions {
            standstill: false,
            ..READY
        };
        let motion = in_state(state).step(word, moving, &options());
        assert_eq!(motion != Motion::Off, moves, "{state:?}");
    }
}

#[test]
fn the_statusword_has_the_bits_of_the_standard() {
    // With voltage (bit 4) and remote (bit 9).
    let mut bench = Bench::new(Mode::None);
    for (word, status) in [
        (0, 0x0250),
        (SHUTDOWN, 0x0231),
        (SWITCH_ON, 0x0233),
        (ENABLE, 0x0237),
        (SWITCH_ON, 0x0233),
    ] {
        assert_eq!(bench.command(word).statusword, status, "{word:#X}");
    }
    bench.input.fault = Fault::Controlled;
    assert_eq!(bench.command(0).statusword, 0x021F);
    assert_eq!(bench.command(0).statusword, 0x0218);
    bench.input.voltage = false;
    assert_eq!(bench.command(0).statusword, 0x0208);
}
