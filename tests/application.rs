//! The firmware's application and the simulator run the same control loop.

use firmware::application::{
    Application, Bridge, DeadBandSettings, MotorLimits, Request, Samples,
    Settings as BoardSettings, Start,
};
use firmware::measure::{MotorConstants, Ripple};
use firmware::parameters::{BoardParameters, LimitSettings, ModelSettings};
use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::control::cascade::Coefficients;
use model_core::control::encoder_correction::EncoderCorrection;
use model_core::control::pwm_timer::PwmCompare;
use model_core::control::units::angle;
use model_core::plant::{Plant, PlantState, first_order::FirstOrder};
use model_core::sensors::{adc::AdcCode, dividers::leg_code};
use model_core::sensors::{encoder::Encoder, noise::Noise};
use system_tests::{INPUTS, command};

/// Samples of a motor with this state and duty: 6 V, 7.7 ohm, 1 mH, and 5.73 V of back-EMF at the
/// full rate of 283.6 deg/s.
fn samples(
    encoder: &mut Encoder,
    state: PlantState,
    duty_pct: f64,
    compare: PwmCompare,
) -> Samples {
    let mut samples = Samples::at_rest(encoder.word(state.angle_deg));
    let back_emf_v = state.rate_deg_s * 5.73 / 283.6;
    let mean_a = (duty_pct / 100.0 * 6.0 - back_emf_v) / 7.7;
    let of_zero = Ripple::of(7.7, 1e-3).over_period(0, compare, 6000);
    let sampled_a = mean_a - f64::from(of_zero.mean_ma) / 1000.0;
    samples.current = Some(AdcCode::from_pin_v(1.65 + 0.5 * sampled_a));
    if let Some(scan) = &mut samples.scan {
        scan.leg_a = leg_code((6.0 + back_emf_v) / 2.0);
        scan.leg_b = leg_code((6.0 - back_emf_v) / 2.0);
    }
    samples
}

#[test]
fn the_enabled_application_gives_the_compare_values_of_the_simulated_board_integer_for_integer() {
    let settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    let motor = || FirstOrder::try_new(settings.first_order, settings.pwm).expect("in range");
    for input in INPUTS {
        let mut simulated = settings.around(motor()).expect("in range");
        let mut plant = motor();
        let mut encoder = Encoder::new(settings.encoder, Noise::new(0, 0));
        let parameters = BoardParameters {
            control: Coefficients::try_new(&settings.control).expect("in range"),
            ..BoardParameters::DEFAULT
        };
        let of_board = BoardSettings {
            board: &parameters,
            motor: &MotorConstants::of(&ModelSettings::DEFAULT),
            limits: &MotorLimits::of(
                &LimitSettings::DEFAULT,
                &parameters,
                &ModelSettings::DEFAULT,
            ),
            dead_band: &DeadBandSettings::default(),
            encoder: &EncoderCorrection::NONE,
            observes_rate: false,
        };
        let mut application = Application::new(&parameters, Start::default());
        // Before the run the encoder is sampled once, then the loop is closed.
        application.control_period(
            of_board,
            &Samples::at_rest(encoder.word(plant.at(0).angle_deg)),
        );
        application
            .request(Request::Enable)
            .expect("nothing is wrong");
        let (mut duty_pct, mut steps) = (0.0, 0);
        let mut last = PwmCompare::default();
        for edge in 0..5000_u64 {
            plant.start_period(duty_pct);
            let target = angle(command(input, edge * 20));
            if edge % 4 == 0 {
                application
                    .request(Request::Command(target.into()))
                    .expect("from the bus");
                let samples = samples(&mut encoder, plant.at(0), duty_pct, last);
                let outputs = application.control_period(of_board, &samples);
                let Bridge::Driven(compare) = outputs.bridge else {
                    panic!("{input}: the bridge is off at edge {edge}");
                };
                duty_pct = outputs.telemetry.duty.to_f64();
                last = compare;
                simulated.start_period(|_| target);
                assert_eq!(outputs.fault, None, "{input}, edge {edge}: {:?}", outputs);
                assert_eq!(compare, simulated.compare(), "{input}, edge {edge}");
                steps += i32::from(compare.get() != 0);
            } else {
                simulated.start_period(|_| target);
            }
        }
        assert!(steps > 100, "{input}: hardly a duty in {steps} steps");
    }
}
