//! C programs against the static library.
#![cfg(unix)]

use std::{
    env,
    fmt::Write as _,
    fs,
    io::Write as _,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use model_core::actuator::{Actuator, InputLevel, ModelKind, PlantKind, Settings};
use model_core::named::Named;
use model_core::plant::Pwm;

/// The static library: cargo builds all kinds of the library for this test.
fn library() -> PathBuf {
    let test = env::current_exe().unwrap();
    test.with_file_name("libactuator_c.a")
}

/// Compiles a C99 program without a warning.
fn compile(folder: &Path, source: &Path) -> PathBuf {
    let program = folder.join("program");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let compiler = env::var_os("CC").unwrap_or_else(|| "cc".into());
    let mut command = Command::new(compiler);
    command.args([
        "-std=c99",
        "-O1",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Werror",
        "-I",
    ]);
    command
        .arg(root.join("include"))
        .arg(source)
        .arg("-o")
        .arg(&program);
    command.arg(library()).args(["-lm", "-lpthread", "-ldl"]);
    assert!(command.status().unwrap().success(), "{source:?}");
    program
}

fn run(program: &Path, arguments: &[&str], input: &str) -> String {
    let mut command = Command::new(program);
    command
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(input.as_bytes())
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{arguments:?}");
    String::from_utf8(output.stdout).unwrap()
}

/// A step of a trace.
struct Step {
    input: InputLevel,
    value: f64,
    ticks: u64,
    load_nm: f64,
    inertia_kg_m2: f64,
}

/// Steps of every sort of length, in every input that the model has.
fn steps(settings: &Settings) -> Vec<Step> {
    let lengths = [1, 7, 20, 80, 83, 400, 1000];
    let has = |input: &InputLevel| input.is_of(settings.model, settings.plant);
    let inputs: Vec<_> = InputLevel::ALL.iter().copied().filter(has).collect();
    let step = |i: u32| Step {
        input: inputs[i as usize / 5 % inputs.len()],
        value: f64::from((i * 37) % 121) - 60.3,
        ticks: lengths[i as usize % lengths.len()],
        load_nm: f64::from(i % 5) * 0.05 - 0.1,
        inertia_kg_m2: f64::from(i % 3) * 1e-3,
    };
    (0..60).map(step).collect()
}

fn line(actuator: &Actuator) -> String {
    let (mut line, load) = (actuator.tick().to_string(), actuator.load());
    let motion = [load.angle_deg, load.rate_deg_s, actuator.shaft_torque_nm()];
    for number in actuator.reading().values().into_iter().chain(motion) {
        write!(line, " {:016x}", number.to_bits()).unwrap();
    }
    line + "\n"
}

fn trace_in_rust(settings: &Settings) -> String {
    let mut actuator = Actuator::try_new(settings).unwrap();
    let mut trace = line(&actuator);
    for step in steps(settings) {
        actuator.set_load_torque_nm(step.load_nm).unwrap();
        actuator.set_load_inertia_kg_m2(step.inertia_kg_m2).unwrap();
        let push = (1e-3 * step.value, 1e-4 * step.load_nm);
        actuator.push_load(push.0, push.1).unwrap();
        actuator
            .advance_with(step.input, step.value, step.ticks)
            .unwrap();
        trace += &line(&actuator);
    }
    trace
}

#[test]
fn c_and_rust_give_the_same_bits_for_every_model_plant_and_preset() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = compile(folder.path(), &root.join("tests/trace.c"));
    let mut compared = 0;
    for (model, plant) in ModelKind::ALL
        .iter()
        .flat_map(|m| PlantKind::ALL.iter().map(move |p| (*m, *p)))
    {
        for preset in model.presets() {
            let mut settings = Settings::new(model, plant);
            (settings.pwm, settings.seed) = (Pwm::Switched, 7);
            if settings.apply(preset).is_err() {
                continue;
            }
            let mut input = String::new();
            for Step {
                input: level,
                value,
                ticks,
                load_nm,
                inertia_kg_m2,
            } in steps(&settings)
            {
                let level = InputLevel::ALL.iter().position(|l| *l == level).unwrap();
                writeln!(input, "{level} {value} {ticks} {load_nm} {inertia_kg_m2}").unwrap();
            }
            // Only the board has a plant.
            let plant_name = match model {
                ModelKind::Board => plant.name(),
                _ => "-",
            };
            let arguments = [model.name(), plant_name, preset.name, "switched", "7"];
            assert_eq!(
                run(&program, &arguments, &input),
                trace_in_rust(&settings),
                "{arguments:?}"
            );
            compared += 1;
        }
    }
    assert!(compared >= 18, "{compared}");
}

#[test]
fn misuse_gives_error_codes_and_no_crash() {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/misuse.c");
    run(&compile(folder.path(), &source), &[], "");
}

#[test]
fn a_long_step_reports_its_progress_is_interrupted_and_gives_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/interrupt.c");
    run(&compile(folder.path(), &source), &[], "");
}

#[test]
fn the_example_of_the_readme_runs() {
    let folder = tempfile::tempdir().unwrap();
    let readme = include_str!("../README.md");
    let code = readme
        .split("```c\n")
        .nth(1)
        .and_then(|rest| rest.split("```").next());
    let source = folder.path().join("example.c");
    fs::write(&source, code.unwrap()).unwrap();
    let printed = run(&compile(folder.path(), &source), &[], "");
    assert!(printed.ends_with(" deg after 1.00 s\n"), "{printed}");
}
