//! The application on the plant whose current pulses.

use model_core::plant::board::{BoardPlant, BoardPlantOptions, SampledBoardPlant};

use super::*;
use crate::native;

/// The application in a closed loop with the plant of the emulated board.
struct Loop {
    application: Configured,
    plant: SampledBoardPlant,
}

impl Loop {
    fn enabled() -> Self {
        let plant = BoardPlant::try_new(&BoardPlantOptions::default()).unwrap();
        let mut board = Self {
            application: Configured::new(BoardParameters::DEFAULT),
            plant: SampledBoardPlant::new(plant, &mut |_, _| {}),
        };
        board.step();
        board.step();
        board.application.request(Request::Enable).unwrap();
        board
    }

    fn step(&mut self) -> Outputs {
        let outputs = self
            .application
            .control_period(&native::samples(&self.plant.sampled()));
        self.plant
            .tick(native::bridge(outputs.bridge), &mut |_, _| {});
        outputs
    }

    /// Control periods with this command; the last outputs.
    fn follow(&mut self, command: Angle, periods: u32) -> Outputs {
        let mut last = None;
        for _ in 0..periods {
            let request = Request::Command(command.into());
            let _ = self.application.request(request);
            last = Some(self.step());
        }
        last.expect("stepped")
    }
}

#[test]
fn a_torque_of_a_third_of_the_stall_torque_is_held() {
    let mut board = Loop::enabled();
    board.plant.plant.defects.torque_nm = -0.3;
    let outputs = board.follow(Angle::ZERO, 1000);
    assert_eq!((outputs.state, outputs.fault), (BoardState::Enabled, None));
    // 0.3 Nm over 1.158 Nm/A; friction of 0.03 Nm helps or hinders.
    let mean_ma = outputs.telemetry.current_ma;
    assert!((230..=290).contains(&mean_ma.abs()), "{mean_ma} mA");
}

#[test]
fn a_reversal_at_the_full_rate_is_no_fault_of_the_encoder_or_of_the_back_emf() {
    let mut board = Loop::enabled();
    let outputs = board.follow(Angle::from_int(150), 120);
    assert!(outputs.telemetry.rate > rate(240.0));
    let forward_mv = outputs.telemetry.back_emf_mv;
    assert!(forward_mv > 4500, "{forward_mv} mV");
    // While the diodes carry the current, the legs differ by the supply and two diodes: 7.4 V.
    for _ in 0..10 {
        let outputs = board.follow(Angle::from_int(-150), 1);
        assert_eq!(outputs.fault, None);
        assert!(outputs.telemetry.rate > rate(60.0));
        // No rotation makes more than the supply.
        let back_emf_mv = outputs.telemetry.back_emf_mv;
        assert!((0..=6000).contains(&back_emf_mv), "{back_emf_mv} mV");
    }
}
