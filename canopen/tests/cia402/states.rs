use canopen::cia402::{
    Cia402State, Conditions, Deceleration, Fault, Mode, Motion, Options, QuickStop, StateMachine,
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

/// A state machine in a state, by the shortest path.
fn in_state(state: Cia402State) -> StateMachine {
    let options = options();
    let mut machine = machine();
    let way: &[u16] = match state {
        Cia402State::NotReadyToSwitchOn => &[],
        Cia402State::SwitchOnDisabled => &[0],
        Cia402State::ReadyToSwitchOn => &[0, SHUTDOWN],
        Cia402State::SwitchedOn => &[0, SHUTDOWN, SWITCH_ON],
        Cia402State::OperationEnabled => &[0, SHUTDOWN, SWITCH_ON, ENABLE],
        Cia402State::QuickStopActive => &[0, SHUTDOWN, SWITCH_ON, ENABLE, QUICK_STOP],
        Cia402State::FaultReactionActive | Cia402State::Fault => &[0, SHUTDOWN, SWITCH_ON, ENABLE],
    };
    for word in way {
        machine.step(*word, READY, &options);
    }
    if matches!(state, Cia402State::FaultReactionActive | Cia402State::Fault) {
        let fault = Conditions {
            fault: Fault::Controlled,
            standstill: false,
            ..READY
        };
        machine.step(ENABLE, fault, &options);
        if state == Cia402State::Fault {
            machine.step(ENABLE, READY, &options);
        }
    }
    assert_eq!(machine.state(), state);
    machine
}

/// Options with a quick stop that remains in "quick stop active", so that transition 16 exists.
fn options() -> Options {
    let stop = StopOption::Stop(Deceleration::QuickStop);
    Options {
        quick_stop: QuickStop {
            stop,
            remains_active: true,
        },
        ..Options::default()
    }
}

#[test]
fn every_transition_matches_the_standard() {
    use Cia402State::{
        Fault as Faulty, FaultReactionActive as Reacting, NotReadyToSwitchOn as NotReady,
        OperationEnabled as Enabled, QuickStopActive as Quick, ReadyToSwitchOn as Rtso,
        SwitchOnDisabled as Sod, SwitchedOn as On,
    };
    // Shutdown, switch on, enable operation, disable voltage, quick stop, fault reset.
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
        (Rtso, [Rtso, On, Enabled, Sod, Sod, Sod]),
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
fn with_bit_7_set_a_controlword_gives_no_power_and_may_remove_it() {
    use Cia402State::{OperationEnabled, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn};
    for state in [
        SwitchOnDisabled,
        ReadyToSwitchOn,
        SwitchedOn,
        OperationEnabled,
    ] {
        for command in [SHUTDOWN, SWITCH_ON, ENABLE] {
            let mut machine = in_state(state);
            for _ in 0..2 {
                machine.step(FAULT_RESET | command, READY, &options());
            }
            assert_eq!(machine.state(), state, "{command:#X}");
        }
    }
    let mut machine = in_state(OperationEnabled);
    machine.step(FAULT_RESET | QUICK_STOP, READY, &options());
    assert_eq!(machine.state(), Cia402State::QuickStopActive);
}

#[test]
fn a_fault_enters_the_fault_state_from_every_state() {
    for state in [
        Cia402State::NotReadyToSwitchOn,
        Cia402State::SwitchOnDisabled,
        Cia402State::ReadyToSwitchOn,
        Cia402State::SwitchedOn,
        Cia402State::OperationEnabled,
        Cia402State::QuickStopActive,
    ] {
        for fault in [Fault::Controlled, Fault::Immediate] {
            let mut machine = in_state(state);
            let conditions = Conditions { fault, ..READY };
            machine.step(ENABLE, conditions, &options());
            assert_eq!(
                machine.state(),
                Cia402State::FaultReactionActive,
                "{state:?}"
            );
            machine.step(ENABLE, conditions, &options());
            assert_eq!(machine.state(), Cia402State::Fault, "{state:?}");
        }
    }
}

#[test]
fn a_fault_is_reset_by_a_rising_edge_once_its_cause_is_gone() {
    let mut machine = in_state(Cia402State::Fault);
    let faulty = Conditions {
        fault: Fault::Controlled,
        ..READY
    };
    machine.step(FAULT_RESET, faulty, &options());
    machine.step(FAULT_RESET, READY, &options());
    assert_eq!(
        machine.state(),
        Cia402State::Fault,
        "an edge while the fault is present has no effect"
    );
    machine.step(0, READY, &options());
    machine.step(FAULT_RESET, READY, &options());
    assert_eq!(machine.state(), Cia402State::SwitchOnDisabled);
}

#[test]
fn the_power_stage_requires_initialisation_and_voltage() {
    let mut machine = machine();
    machine.step(
        SHUTDOWN,
        Conditions {
            initialised: false,
            ..READY
        },
        &options(),
    );
    assert_eq!(machine.state(), Cia402State::NotReadyToSwitchOn);
    let mut machine = in_state(Cia402State::ReadyToSwitchOn);
    machine.step(
        SWITCH_ON,
        Conditions {
            voltage: false,
            ..READY
        },
        &options(),
    );
    assert_eq!(machine.state(), Cia402State::ReadyToSwitchOn);
}

#[test]
fn only_states_with_power_have_a_demand() {
    for (state, moves) in [
        (Cia402State::SwitchOnDisabled, false),
        (Cia402State::ReadyToSwitchOn, false),
        (Cia402State::SwitchedOn, false),
        (Cia402State::OperationEnabled, true),
        (Cia402State::QuickStopActive, true),
        (Cia402State::FaultReactionActive, true),
        (Cia402State::Fault, false),
    ] {
        let word = match state {
            Cia402State::OperationEnabled => ENABLE,
            Cia402State::SwitchedOn => SWITCH_ON,
            Cia402State::QuickStopActive => QUICK_STOP,
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
fn the_statusword_has_the_state_bits_of_the_standard() {
    // With "voltage enabled" (bit 4) and "remote" (bit 9).
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

#[test]
fn a_fault_without_power_starts_no_stop() {
    let fault = Conditions {
        fault: Fault::Controlled,
        standstill: false,
        ..READY
    };
    let options = Options {
        fault_reaction: StopOption::Stop(Deceleration::QuickStop),
        ..options()
    };
    for state in [Cia402State::ReadyToSwitchOn, Cia402State::SwitchedOn] {
        let motion = in_state(state).step(SWITCH_ON, fault, &options);
        assert_eq!(motion, Motion::Off, "{state:?}");
    }
    let motion = in_state(Cia402State::OperationEnabled).step(ENABLE, fault, &options);
    assert_eq!(motion, Motion::Stop(Deceleration::QuickStop));
}
