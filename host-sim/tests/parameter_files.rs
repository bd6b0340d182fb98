//! Every model fitted to every input has a parameter file that the simulator accepts, and its trace
//! is the prediction of the fit.

use host_sim::{scenario::Scenario, trace::Trace};
use identification::{
    Experiment, Fit, Hold, Limits, Model, Options, Problem, Quiet, Recording, engine, models,
    parameter_file,
    synthetic::{noisy, simulated},
};
use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
use model_core::excitation::catalogue::Input;
use std::sync::Arc;

/// Inputs, with the course of their commands between samples.
const INPUTS: [(&str, Hold); 4] = [
    ("pulse", Hold::Zero),
    ("chirp", Hold::Smooth),
    ("sine", Hold::Smooth),
    ("3-2-1-1", Hold::Zero),
];

/// Recordings of the board's loop: with duty for the motors, and long enough for their parameters.
fn of_the_board(input: &str, hold: Hold) -> Recording {
    let mut settings = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
    settings.set("backlash_deg", 0.0).expect("a parameter");
    let mut actuator = Actuator::try_new(&settings).expect("defaults");
    let input = Input::named(input).expect("an input");
    let excitation = input.excitation().expect("defaults");
    let mut recording = Recording {
        name: input.name().into(),
        duty_pct: Some(Vec::new()),
        hold,
        ..Recording::default()
    };
    for tick in 0..input.duration_ticks().expect("defaults") {
        let command_deg = excitation.command(tick).to_f64();
        if tick.is_multiple_of(80) {
            let reading = actuator.reading();
            recording.time_s.push(model_core::time::seconds(tick));
            recording.command_deg.push(command_deg);
            recording.angle_deg.push(reading.angle_deg);
            recording
                .duty_pct
                .as_mut()
                .expect("a column")
                .push(reading.duty_pct);
        }
        actuator.advance(command_deg, 1).expect("a finite command");
    }
    recording
}

fn fitted(model: &Arc<dyn Model>, recording: Recording) -> Fit {
    let run = Experiment::try_new(recording).expect("a recording");
    let mut problem = Problem::try_new(model.clone(), vec![run]).expect("a problem");
    // The simulator starts at rest at zero.
    problem.fix("initial_angle_deg", 0.0).expect("a parameter");
    let options = Options {
        starts: 1,
        // Friction takes long, and its file is as valid on the way to the optimum.
        limits: Limits {
            iterations: if model.has_many_minima() { 5 } else { 200 },
            ..Limits::default()
        },
        ..Options::default()
    };
    engine::fit(&problem, &options, &Quiet).expect("a fit")
}

/// The trace of a fit's parameter file.
fn simulated_again(fit: &Fit, input: &str) -> Trace {
    let text = parameter_file::text(fit).expect("it can be simulated");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("fitted.toml");
    std::fs::write(&path, &text).expect("a file");
    let mut scenario = Scenario::read(&path).expect(&text);
    scenario.input = Some(input.into());
    scenario.every = Some(80);
    let simulation = scenario
        .resolve()
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    simulation.record().expect("a run")
}

#[test]
fn every_fit_to_every_input_can_be_simulated() {
    for (input, hold) in INPUTS {
        let recording = of_the_board(input, hold);
        for model in models::all() {
            let fit = fitted(&model, recording.clone());
            let trace = simulated_again(&fit, input);
            if models::of_the_paper()
                .iter()
                .all(|m| m.name() != model.name())
            {
                // A motor is simulated within loops that are sampled.
                continue;
            }
            let angles = trace.column("angle_deg").expect("a column");
            let predicted = &fit.experiments[0].predicted_deg;
            let errors = angles.iter().zip(predicted).map(|(a, b)| (a - b).abs());
            let worst = errors.fold(0.0, f64::max);
            // The simulator holds its command for a tick of 50 us, and its limits act at ticks: at
            // 400 deg/s two hundredths of a degree each.
            assert!(worst < 0.05, "{} {input}: {worst} deg", model.name());
        }
    }
}

#[test]
fn every_fit_to_a_black_box_can_be_simulated() {
    for kind in [ModelKind::BlackBox1, ModelKind::BlackBox2] {
        for (input, hold) in INPUTS {
            let mut recording = noisy(simulated(kind, input, 80, &[]).expect("a run"), 1);
            recording.hold = hold;
            for model in models::of_the_paper() {
                simulated_again(&fitted(&model, recording.clone()), input);
            }
        }
    }
}
