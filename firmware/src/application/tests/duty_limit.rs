//! The limit of the duty holds in every state that drives the motor.

use model_core::control::{cascade::Coefficients, parameters::ControlParameters, units::percent};

use super::*;

/// The default parameters with this limit of the duty.
fn with_duty_limit(duty_limit_pct: f64) -> BoardParameters {
    let control = ControlParameters {
        duty_limit_pct,
        ..ControlParameters::DEFAULT
    };
    BoardParameters {
        control: Coefficients::try_new(&control).unwrap(),
        ..BoardParameters::DEFAULT
    }
}

#[test]
fn a_stop_by_the_back_emf_stays_within_the_duty_limit() {
    let mut board = TestBoard::turning();
    assert_eq!(board.application.retune(&with_duty_limit(20.0)), Ok(()));
    board.step();
    let mut greatest_pct = 0.0_f64;
    while board.step_with(|samples| samples.encoder = None).state != BoardState::Fault {
        if board.outputs.state == BoardState::FaultReaction {
            greatest_pct = greatest_pct.max(board.outputs.telemetry.duty.abs().to_f64());
        }
    }
    // Three quarters of the back-EMF are more at first.
    assert_eq!(greatest_pct, 20.0);
}

#[test]
fn a_duty_that_is_held_without_a_count_stays_within_a_narrowed_limit() {
    let mut board = TestBoard::turning();
    assert_eq!(board.outputs.telemetry.duty, percent(100.0));
    assert_eq!(board.application.retune(&with_duty_limit(20.0)), Ok(()));
    let outputs = board.step_with(|samples| samples.encoder = None);
    assert_eq!(outputs.state, BoardState::Enabled);
    assert_eq!(outputs.telemetry.duty, percent(20.0));
    let Bridge::Driven(compare) = outputs.bridge else {
        panic!("{:?}", outputs.bridge);
    };
    assert_eq!(compare.duty_pct(), 20.0);
}
