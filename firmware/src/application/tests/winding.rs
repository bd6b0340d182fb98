//! The application on the plant whose current pulses.

use model_core::{
    control::units::angle,
    plant::board::{BoardPlant, BoardPlantOptions, SampledBoardPlant},
};

use super::*;
use crate::{measure, native};

/// The application in a closed loop with the plant of the emulated board.
pub(super) struct Loop {
    pub application: Configured,
    pub plant: SampledBoardPlant,
}

impl Loop {
    pub fn enabled() -> Self {
        Self::with(&BoardPlantOptions::default())
    }

    /// With this plant.
    pub fn with(options: &BoardPlantOptions) -> Self {
        let plant = BoardPlant::try_new(options).unwrap();
        let mut board = Self {
            application: Configured::new(BoardParameters::DEFAULT),
            plant: SampledBoardPlant::new(plant, &mut |_, _| {}),
        };
        board.step();
        board.step();
        board.application.request(Request::Enable).unwrap();
        board
    }

    pub fn step(&mut self) -> Outputs {
        let outputs = self
            .application
            .control_period(&native::samples(&self.plant.sampled()));
        self.plant
            .tick(native::bridge(outputs.bridge), &mut |_, _| {});
        outputs
    }

    /// Control periods with this command; the last outputs.
    pub fn follow(&mut self, command: Angle, periods: u32) -> Outputs {
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

#[test]
fn a_reversal_at_the_full_rate_hides_the_back_emf_for_20_ms() {
    let mut board = Loop::enabled();
    board.follow(Angle::from_int(150), 120);
    let mut hidden = 0;
    for _ in 0..120 {
        let scan = native::samples(&board.plant.sampled()).scan.unwrap();
        hidden += u32::from(measure::back_emf_mv(scan.leg_a, scan.leg_b, scan.supply).is_none());
        board.follow(Angle::from_int(-150), 1);
    }
    assert_eq!(hidden, 5, "control periods");
}

/// A drive as one finds it, whose back-EMF is this share of that of object 2011h, with a degree of
/// play and a magnet either way, at rest with the bridge off for 0.2 s, and then enabled.
fn found(seed: u64, constant: f64, is_reversed: bool) -> Loop {
    let mut options = BoardPlantOptions::realistic(seed);
    options.drivetrain.electrical.torque_constant_nm_a *= constant;
    options.drivetrain.gear_train.backlash_deg = 1.0;
    let direction = if is_reversed { -1.0 } else { 1.0 };
    options.encoder.magnet_direction = direction;
    let parameters = with_gains(ControlParameters {
        encoder_direction: direction,
        ..ControlParameters::DEFAULT
    });
    let plant = BoardPlant::try_new(&options).unwrap();
    let mut board = Loop {
        application: Configured::new(parameters),
        plant: SampledBoardPlant::new(plant, &mut |_, _| {}),
    };
    for _ in 0..50 {
        board.step();
    }
    board.application.request(Request::Enable).unwrap();
    board
}

#[test]
fn a_sound_encoder_is_plausible_in_steps_and_ramps_with_a_constant_off_by_30_percent() {
    let of_encoder = FaultSet::of(&[
        Fault::EncoderStuck,
        Fault::EncoderJump,
        Fault::EncoderImplausible,
    ]);
    for (seed, constant) in (0..4).flat_map(|seed| [0.7, 1.0, 1.3].map(|k| (seed, k))) {
        let mut board = found(seed, constant, seed % 2 == 1);
        let mut chance = Noise::new(seed, 1);
        for _ in 0..40 {
            let target = angle(chance.gaussian(30.0).clamp(-60.0, 60.0));
            let from = board.application.telemetry().angle;
            // In a step, or within half a second.
            let periods = if chance.gaussian(1.0) > 0.0 { 1 } else { 125 };
            for period in 1..=150 {
                let share = f64::from(period.min(periods)) / f64::from(periods);
                let command = from.to_f64() + share * (target - from).to_f64();
                let outputs = board.follow(angle(command), 1);
                let found = outputs.telemetry.latched.and(of_encoder);
                assert!(
                    found.is_empty(),
                    "seed {seed}, {constant}: {:?}",
                    outputs.fault
                );
            }
        }
        let telemetry = board.application.telemetry();
        assert!(telemetry.latched.is_empty(), "{:?}", telemetry.latched);
    }
}
