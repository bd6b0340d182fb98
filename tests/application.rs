//! The firmware's application and the simulator run the same control loop.

use firmware::application::{Application, Bridge, Request, Samples};
use firmware::parameters::BoardParameters;
use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::control::cascade::Coefficients;
use model_core::control::units::angle;
use model_core::plant::{Plant, first_order::FirstOrder};
use model_core::sensors::{encoder::Encoder, noise::Noise};
use system_tests::{INPUTS, command};

#[test]
fn the_enabled_application_gives_the_compare_values_of_the_simulated_board_integer_for_integer() {
    let settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    let motor = || FirstOrder::try_new(settings.first_order, settings.pwm).expect("in range");
    for input in INPUTS {
        let mut simulated = settings.around(motor()).expect("in range");
        let mut plant = motor();
        let mut encoder = Encoder::new(settings.encoder, Noise::new(0, 0));
        let mut application = Application::new(BoardParameters {
            control: Coefficients::try_new(&settings.control).expect("in range"),
            ..BoardParameters::DEFAULT
        });
        // Before the run the encoder is sampled once, then the loop is closed.
        application.step(&Samples::at_rest(encoder.word(plant.at(0).angle_deg)));
        application
            .request(Request::Enable)
            .expect("nothing is wrong");
        let (mut duty_pct, mut steps) = (0.0, 0);
        for edge in 0..5000_u64 {
            plant.start_period(duty_pct);
            let target = angle(command(input, edge * 20));
            if edge % 4 == 0 {
                application
                    .request(Request::Command(target.into()))
                    .expect("from the bus");
                let samples = Samples::at_rest(encoder.word(plant.at(0).angle_deg));
                let outputs = application.step(&samples);
                let Bridge::Driven(compare) = outputs.bridge else {
                    panic!("{input}: the bridge is off at edge {edge}");
                };
                duty_pct = outputs.telemetry.duty.to_f64();
                simulated.start_period(|_| target);
                assert_eq!(outputs.fault, None, "{input}, edge {edge}: {:?}", outputs);
                assert_eq!(compare, simulated.compare, "{input}, edge {edge}");
                steps += i32::from(compare.get() != 0);
            } else {
                simulated.start_period(|_| target);
            }
        }
        assert!(steps > 100, "{input}: hardly a duty in {steps} steps");
    }
}
