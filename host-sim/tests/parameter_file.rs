//! What was fitted is simulated again.

use model_core::excitation::catalogue::Input;

use host_sim::{
    input::Command,
    scenario::Scenario,
    settings::{ModelKind, PlantKind, Settings},
    simulate::Simulation,
    trace::Trace,
};
use identification::{
    Experiment, Options, Problem, Quiet, Recording, engine, models::named, parameter_file,
};

/// A servo that is a position loop: 2 % of duty for a degree.
const SERVO: [(&str, f64); 9] = [
    ("position_gain", 10.0),
    ("feed_forward_gain", 0.2),
    ("proportional_gain", 0.0),
    ("integral_gain", 0.0),
    ("anti_windup_gain", 0.0),
    ("bearing_friction_nm", 0.0),
    ("backlash_deg", 0.0),
    ("pendulum_mass_kg", 0.3),
    ("delay_s", 0.0),
];

fn recorded(set: &[(&str, f64)]) -> Trace {
    let mut settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
    for (name, value) in set {
        settings
            .set(name, *value)
            .expect("a parameter of the bench");
    }
    let input = Input::named("variable-step").expect("an input");
    let simulation = Simulation {
        settings,
        command: Command::Excitation(input.excitation().expect("it is in range")),
        input: input.name().into(),
        load: None,
        ticks: input.duration_ticks().expect("it is in range"),
        every: 80,
        progress: None,
    };
    simulation.record().expect("a run")
}

fn column(trace: &Trace, name: &str) -> Vec<f64> {
    trace.column(name).expect("a column").to_vec()
}

fn recording(trace: &Trace) -> Recording {
    let constants = [("pendulum_mass_kg", 0.3), ("pendulum_length_m", 0.1)];
    Recording {
        name: "bench".into(),
        time_s: column(trace, "time_s"),
        command_deg: column(trace, "command_deg"),
        angle_deg: column(trace, "angle_deg"),
        duty_pct: Some(column(trace, "duty_pct")),
        constants: constants.map(|(n, v)| (n.to_owned(), v)).into(),
        ..Recording::default()
    }
}

/// The parameter file of a model fitted to a bench with these settings, and its simulation.
fn again(model: &str, trace: &Trace) -> (String, Trace) {
    let experiment = Experiment::try_new(recording(trace)).expect("a recording");
    let mut problem =
        Problem::try_new(named(model).expect("a model"), vec![experiment]).expect("it");
    problem
        .fix("winding_resistance_ohm", 7.7)
        .expect("it has one");
    problem.fix("supply_v", 6.0).expect("it has one");
    let options = Options {
        starts: 1,
        ..Options::default()
    };
    let fit = engine::fit(&problem, &options, &Quiet).expect("a fit");
    let text = parameter_file::text(&fit).expect("it can be simulated");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fitted.toml");
    std::fs::write(&path, &text).expect("a file");
    let mut scenario = Scenario::read(&path).expect("a scenario");
    scenario.input = Some("variable-step".into());
    scenario.every = Some(80);
    let simulation = scenario.resolve().expect("valid parameters of the bench");
    (text, simulation.record().expect("a run"))
}

fn rms_deg(a: &Trace, b: &Trace) -> f64 {
    let (a, b) = (column(a, "angle_deg"), column(b, "angle_deg"));
    let squares = a.iter().zip(&b).map(|(a, b)| (a - b).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn a_fitted_servo_is_simulated_with_its_own_position_loop() {
    let trace = recorded(&SERVO);
    let (text, answer) = again("servo-m1", &trace);
    assert!(
        text.contains("model = \"board\"\nplant = \"bench\"\n"),
        "{text}"
    );
    // Of steps up to 120 deg. The board samples its loop every 4 ms, which the fitted model does
    // not include.
    let error = rms_deg(&trace, &answer);
    assert!(error < 0.5, "{error} deg\n{text}");
}

#[test]
fn a_fitted_motor_is_simulated_within_the_boards_loops() {
    let bench = [
        ("bearing_friction_nm", 0.0),
        ("backlash_deg", 0.0),
        ("pendulum_mass_kg", 0.3),
    ];
    let trace = recorded(&bench);
    let (text, answer) = again("motor-m1", &trace);
    assert!(text.contains("friction_model = 1.0\n"), "{text}");
    // The loops of the board forgive the motor much.
    let error = rms_deg(&trace, &answer);
    assert!(error < 0.5, "{error} deg\n{text}");
}
