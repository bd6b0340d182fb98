//! C programs against the static library.
#![cfg(unix)]

use std::{
    env,
    fmt::Write as _,
    fs,
    io::Write as _,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    sync::LazyLock,
};

use model_core::actuator::{Actuator, ModelKind, PlantKind, Reading, Settings};
use model_core::named::Named;
use model_core::plant::Pwm;

/// The static library, built as any user of it would.
static LIBRARY: LazyLock<PathBuf> = LazyLock::new(|| {
    // Cargo's folder for tests is in the target folder.
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let mut build = Command::new(env!("CARGO"));
    build.args([
        "build",
        "--quiet",
        "--locked",
        "-p",
        "actuator-c",
        "--target-dir",
    ]);
    let built = build
        .arg(target)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .status();
    assert!(built.unwrap().success());
    target.join("debug/libactuator_c.a")
});

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
    command.arg(&*LIBRARY).args(["-lm", "-lpthread", "-ldl"]);
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

/// Steps of every sort of length, in deg, ticks and Nm.
fn steps() -> impl Iterator<Item = (f64, u64, f64)> {
    let lengths = [1, 7, 20, 80, 83, 400, 1000];
    (0..60_u32).map(move |i| {
        let command_deg = f64::from((i * 37) % 121) - 60.3;
        let load_nm = f64::from(i % 5) * 0.05 - 0.1;
        (command_deg, lengths[i as usize % lengths.len()], load_nm)
    })
}

fn line(tick: u64, r: &Reading) -> String {
    let mut line = tick.to_string();
    for number in r.values() {
        write!(line, " {:016x}", number.to_bits()).unwrap();
    }
    line + "\n"
}

fn trace_in_rust(settings: &Settings) -> String {
    let mut actuator = Actuator::try_new(settings).unwrap();
    let mut trace = line(0, &actuator.reading());
    for (command_deg, ticks, load_nm) in steps() {
        actuator.set_load_torque_nm(load_nm).unwrap();
        actuator.advance(command_deg, ticks).unwrap();
        trace += &line(actuator.tick(), &actuator.reading());
    }
    trace
}

#[test]
fn c_and_rust_give_the_same_bits_for_every_model_plant_and_preset() {
    let folder = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let program = compile(folder.path(), &root.join("tests/trace.c"));
    let input: String = steps().map(|(c, t, l)| format!("{c} {t} {l}\n")).collect();
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
