//! Bits and codes, by their numbers in CiA 402.

use canopen::cia402::{
    Cia402State, Deceleration, Mode, QuickStop, StopOption, controlword, statusword,
};

#[test]
fn the_bits_of_the_controlword_have_their_positions() {
    use controlword::{
        CHANGE_SET_IMMEDIATELY, ENABLE_OPERATION, ENABLE_VOLTAGE, FAULT_RESET, HALT, NEW_SET_POINT,
        QUICK_STOP, RELATIVE, SWITCH_ON,
    };
    let bits = [
        SWITCH_ON,
        ENABLE_VOLTAGE,
        QUICK_STOP,
        ENABLE_OPERATION,
        NEW_SET_POINT,
        CHANGE_SET_IMMEDIATELY,
        RELATIVE,
        FAULT_RESET,
        HALT,
    ];
    let positions = bits.map(u16::trailing_zeros);
    assert_eq!(positions, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
}

#[test]
fn the_bits_of_the_statusword_have_their_positions() {
    use statusword::{FOLLOWING_ERROR, INTERNAL_LIMIT, MODE_12, REMOTE, TARGET_REACHED};
    use statusword::{VOLTAGE_ENABLED, WARNING};
    let bits = [
        VOLTAGE_ENABLED,
        WARNING,
        REMOTE,
        TARGET_REACHED,
        INTERNAL_LIMIT,
        MODE_12,
        FOLLOWING_ERROR,
    ];
    let positions = bits.map(u16::trailing_zeros);
    assert_eq!(positions, [4, 7, 9, 10, 11, 12, 13]);
}

#[test]
fn each_state_has_its_bits_of_the_statusword() {
    for (state, bits) in [
        (Cia402State::NotReadyToSwitchOn, 0x00),
        (Cia402State::SwitchOnDisabled, 0x40),
        (Cia402State::ReadyToSwitchOn, 0x21),
        (Cia402State::SwitchedOn, 0x23),
        (Cia402State::OperationEnabled, 0x27),
        (Cia402State::QuickStopActive, 0x07),
        (Cia402State::FaultReactionActive, 0x0F),
        (Cia402State::Fault, 0x08),
    ] {
        assert_eq!(state.statusword(), bits, "{state:?}");
    }
}

#[test]
fn each_mode_has_its_code_and_its_bit_of_6502h() {
    let modes = [
        (0, Mode::None),
        (1, Mode::ProfilePosition),
        (3, Mode::ProfileVelocity),
        (4, Mode::ProfileTorque),
        (6, Mode::Homing),
        (7, Mode::InterpolatedPosition),
        (8, Mode::CyclicPosition),
        (9, Mode::CyclicVelocity),
        (10, Mode::CyclicTorque),
    ];
    for (code, mode) in modes {
        assert_eq!(Mode::from_code(code), Some(mode));
    }
    let others = (i8::MIN..=i8::MAX).filter(|code| Mode::from_code(*code).is_none());
    assert_eq!(others.count(), 256 - modes.len());
    // Bit 0 is that of mode 1.
    let bits = modes[1..].iter().map(|(code, _)| 1 << (code - 1));
    assert_eq!(Mode::SUPPORTED, bits.sum());
}

#[test]
fn each_quick_stop_option_code_has_its_stop_and_its_final_state() {
    let stop = StopOption::Stop;
    for (code, expected, remains_active) in [
        (0, StopOption::Disable, false),
        (1, stop(Deceleration::SlowDown), false),
        (2, stop(Deceleration::QuickStop), false),
        (3, stop(Deceleration::Limit), false),
        (4, stop(Deceleration::Limit), false),
        (5, stop(Deceleration::SlowDown), true),
        (6, stop(Deceleration::QuickStop), true),
        (7, stop(Deceleration::Limit), true),
        (8, stop(Deceleration::Limit), true),
    ] {
        let option = QuickStop::from_code(code).expect("an option");
        assert_eq!(
            (option.stop, option.remains_active),
            (expected, remains_active)
        );
    }
    assert_eq!([-1, 9].map(QuickStop::from_code), [None; 2]);
}
