//! `actuator identify`, `compare` and `experiment`, from a file to the results.

use super::Cli;

/// A directory with a recording of black box 1 on a pulse, `pulse.csv`.
fn cli_with_pulse() -> Cli {
    let cli = Cli::new();
    cli.text("simulate black-box-1 --input pulse --every 80 --csv pulse.csv");
    cli
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).expect("JSON")
}

fn parameter<'a>(document: &'a serde_json::Value, name: &str) -> &'a serde_json::Value {
    let parameters = document["models"][0]["parameters"]
        .as_array()
        .expect("a list");
    let found = parameters.iter().find(|p| p["name"] == name);
    found.unwrap_or_else(|| panic!("no parameter {name}"))
}

#[test]
fn the_parameters_of_a_simulated_trace_are_recovered() {
    let cli = cli_with_pulse();
    let document = json(&cli.text("identify pulse.csv --model black-box-1 --json -"));
    assert_eq!(document["models"][0]["name"], "black-box-1");
    for (name, truth) in [
        ("pole_rad_s", 30.0),
        ("delay_s", 0.0175),
        ("rate_limit_up_deg_s", 240.0),
        ("rate_limit_down_deg_s", 350.0),
    ] {
        let found = parameter(&document, name);
        let estimate = found["estimate"].as_f64().expect("a number");
        // The trace has no noise; the integration error is about one millionth.
        assert!(
            (estimate / truth - 1.0).abs() < 1e-4,
            "{name} is {estimate}"
        );
        assert_eq!(found["identifiable"], true);
        assert_eq!(found["at_bound"], false);
    }
    let limited = &document["models"][0]["experiments"][0]["limited"];
    assert!(limited["rate_limited_s"].as_f64().expect("a number") > 0.5);
}

#[test]
fn a_report_is_one_file_and_a_comparison_names_the_sufficient_model() {
    let cli = cli_with_pulse();
    cli.text("simulate black-box-1 --input 3-2-1-1 --every 80 --csv other.csv");
    let text = cli.text(
        "compare pulse.csv --model black-box-1 --model black-box-2 --starts 2 --validate other.csv \
         --html report.html --json all.json",
    );
    assert!(text.contains("black-box-1 is enough"), "{text}");
    let html = cli.read("report.html");
    assert!(html.contains("Validation") && html.contains("other.csv"));
    let document = json(&cli.read("all.json"));
    assert_eq!(document["ranking"]["enough"], "black-box-1");
    assert_eq!(document["models"].as_array().map(Vec::len), Some(8));
}

#[test]
fn a_cross_validation_predicts_each_recording_by_the_fit_to_the_others() {
    let cli = cli_with_pulse();
    for input in ["3-2-1-1", "variable-step"] {
        let out = format!("simulate black-box-1 --input {input} --every 80 --csv {input}.csv");
        cli.text(&out);
    }
    let all = ["pulse.csv", "3-2-1-1.csv", "variable-step.csv"];
    let arguments = "--model black-box-1 --starts 2 --leave-one-out";
    let text = cli.text(&format!(
        "compare {} {arguments} --html report.html --json all.json",
        all.join(" ")
    ));
    assert!(
        text.contains("predicted by the fit to all others"),
        "{text}"
    );
    assert!(text.contains("black-box-1 is enough"), "{text}");
    let table = text.find("on each held-out recording").expect("the table");
    assert!(
        all.iter().all(|name| text[table..].contains(name)),
        "{text}"
    );
    let html = cli.read("report.html");
    assert!(html.contains("Validation: each recording predicted by a fit without it"));
    let document = json(&cli.read("all.json"));
    let model = &document["models"][0];
    for part in ["experiments", "validation"] {
        let runs = model[part].as_array().expect("a list");
        let names: Vec<_> = runs.iter().map(|run| run["name"].as_str()).collect();
        assert_eq!(names, all.map(Some), "{part}");
    }
    let criterion = document["ranking"]["criterion"].as_str();
    assert!(criterion.is_some_and(|text| text.contains("all others")));

    for (arguments, expected) in [
        (
            "compare pulse.csv --leave-one-out",
            "--leave-one-out with one recording, expected at least two",
        ),
        (
            "compare pulse.csv 3-2-1-1.csv --leave-one-out --validate variable-step.csv",
            "cannot be used with",
        ),
    ] {
        let failure = cli.actuator(arguments).assert().code(2);
        let said = String::from_utf8_lossy(&failure.get_output().stderr).into_owned();
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn the_error_of_an_unusable_file_names_it() {
    let cli = cli_with_pulse();
    let header = "t,command_deg,angle_deg\n";
    cli.write("empty.csv", "");
    cli.write("three.csv", format!("{header}0,0,0\n1,1,1\n2,1,1\n"));
    let rows: String = (0..50).map(|i| format!("{i},1,1\n")).collect();
    cli.write("rest.csv", format!("{header}{rows}"));
    cli.write(
        "nan.csv",
        format!("{header}{}", rows.replace(",1,1", ",1,nan")),
    );
    cli.write("words.csv", format!("{header}0,0,0\n1,0,fast\n"));
    for (file, expected) in [
        ("empty.csv", "empty.csv:1: the file is empty"),
        (
            "three.csv",
            "three.csv: 3 samples with an angle, expected at least 8",
        ),
        (
            "rest.csv",
            "nothing can be identified from a recording at rest",
        ),
        ("nan.csv", "0 samples with an angle"),
        (
            "words.csv",
            "words.csv:3: column 3 (`angle_deg`) is not a finite number",
        ),
    ] {
        let failure = cli.actuator(&format!("identify {file}")).assert().code(2);
        let said = String::from_utf8_lossy(&failure.get_output().stderr).into_owned();
        assert!(said.contains(expected), "{file}: {said}");
    }
    cli.actuator("identify missing.csv").assert().code(1);
    let typo = cli
        .actuator("identify pulse.csv --fix pole=30")
        .assert()
        .code(2);
    let said = String::from_utf8_lossy(&typo.get_output().stderr).into_owned();
    assert!(said.contains("did you mean `pole_rad_s`"), "{said}");
}

#[test]
fn columns_and_units_are_mapped_and_irregularities_are_reported_with_their_lines() {
    let cli = cli_with_pulse();
    let trace = cli.trace("black-box-1 --input pulse --every 80");
    let (t, u, y) = (
        trace.column("time_s"),
        trace.column("command_deg"),
        trace.column("angle_deg"),
    );
    let row = |i: usize| {
        format!(
            "{};{};{}\n",
            1e3 * t[i],
            u[i].to_radians(),
            y[i].to_radians()
        )
    };
    let rows: String = (0..t.len())
        .filter(|i| !(800..850).contains(i))
        .map(row)
        .collect();
    cli.write("odd.txt", format!("clock;want;have\n{rows}"));
    let output = cli
        .actuator(
            "identify odd.txt --model black-box-1 --column time=clock:ms --column \
             command=want:rad --column angle=have:rad --json -",
        )
        .assert()
        .success();
    let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(
        said.contains("odd.txt:802: 1 gaps without samples"),
        "{said}"
    );
    let document = json(&String::from_utf8_lossy(&output.get_output().stdout));
    let pole = parameter(&document, "pole_rad_s")["estimate"].as_f64();
    assert!(pole.is_some_and(|p| (p - 30.0).abs() < 0.01), "{pole:?}");
}

#[test]
fn a_motor_that_is_driven_by_its_duty_needs_no_command() {
    let cli = Cli::new();
    cli.text("simulate board --plant bench --input 3-2-1-1 --every 80 --csv run.csv");
    let run = cli.read("run.csv");
    let names: Vec<&str> = run.lines().next().expect("a header").split(',').collect();
    let kept: Vec<usize> = ["time_s", "duty_pct", "angle_meas_deg"]
        .map(|name| names.iter().position(|n| *n == name).expect("a column"))
        .into();
    let line = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        kept.iter()
            .map(|i| fields[*i])
            .collect::<Vec<_>>()
            .join(",")
            + "\n"
    };
    cli.write("duty.csv", run.lines().map(line).collect::<String>());
    let found = |file: &str| {
        let options = "--model motor-m1 --starts 1 --fix winding_resistance_ohm=7.7 \
            --fix torque_constant_nm_a=1.16 --json -";
        let document = json(&cli.text(&format!("identify {file} {options}")));
        parameter(&document, "motor_inertia_kg_m2")["estimate"].clone()
    };
    assert_eq!(found("duty.csv"), found("run.csv"));
    // Another model needs it.
    cli.assert_error(
        "identify duty.csv --model motor-m1 --model black-box-1",
        2,
        "no column is known to be the command",
    );
}

#[test]
fn a_fit_that_has_not_converged_has_a_status_of_its_own_and_determines_nothing() {
    let cli = Cli::new();
    cli.text("simulate board --plant bench --input 3-2-1-1 --every 80 --csv run.csv");
    // Only the ratios of torque constant, inertia and friction show.
    let fit = "identify run.csv --model motor-m1 --starts 1 --fix winding_resistance_ohm=7.7 \
        --parameters open.toml";
    let run = cli.actuator(fit).assert().code(3);
    let error = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    assert!(
        error.contains("error: the search has not converged: the values of motor-m1"),
        "{error}"
    );
    let file: toml::Table = cli.read("open.toml").parse().expect("TOML");
    let open = file["undetermined"].as_array().expect("a list");
    for name in ["torque_constant_nm_a", "motor_inertia_kg_m2"] {
        assert!(
            open.iter().any(|open| open.as_str() == Some(name)),
            "{open:?}"
        );
    }
    // The simulator takes them all the same.
    cli.text("simulate --parameters open.toml --duration 0.1");
}

#[test]
fn an_offset_that_is_nearly_zero_does_not_decide_which_input_is_best() {
    let cli = Cli::new();
    let command = "experiment black-box-1 --duration 6 --input variable-step --input log-chirp";
    let exact = cli.text(command);
    // What a fit without noise has estimated.
    let nearly = cli.text(&format!("{command} --set offset_deg=-5.9e-10"));
    assert_eq!(nearly, exact);
    let known = cli.text(&format!("{command} --set offset_deg=2"));
    assert_ne!(known, exact, "an offset beyond its error has a share");
}

#[test]
fn a_designed_experiment_reaches_its_predicted_accuracy_in_simulation() {
    let cli = Cli::new();
    let document = json(&cli.text("experiment black-box-1 --duration 6 --json --csv best.csv"));
    let best = document["best"].as_u64().expect("there is one") as usize;
    let best = &document["inputs"][best];
    let errors = best["parameters"].as_array().expect("a list");
    assert!(errors.iter().all(|p| p["identifiable"] == true), "{best}");
    cli.text("simulate black-box-1 --input-file best.csv --every 80 --duration 6 --csv run.csv");
    let found = json(&cli.text("identify run.csv --model black-box-1 --hold zero --json -"));
    let pole = parameter(&found, "pole_rad_s");
    assert!((pole["estimate"].as_f64().expect("a number") - 30.0).abs() < 0.01);

    let text = cli.text("experiment black-box-1 --input doublet --input prbs");
    assert!(text.contains("simulate --input"), "{text}");
    cli.actuator("experiment black-box-1 --duration 0")
        .assert()
        .code(2);
    cli.actuator("experiment black-box-1 --set pole=3")
        .assert()
        .code(2);
}

/// The commands of the worked example, one after the other.
#[test]
fn the_worked_example_of_the_documentation_runs() {
    let document = include_str!("../../../docs/identification.md");
    let commands: Vec<&str> = document
        .lines()
        .filter_map(|line| line.strip_prefix("$ actuator "))
        .collect();
    assert_eq!(commands.len(), 9);
    let cli = Cli::new();
    let said: Vec<String> = commands.iter().map(|command| cli.text(command)).collect();
    assert!(said[2].contains("pole_rad_s"), "{}", said[2]);
    for comparison in &said[3..5] {
        assert!(comparison.contains("is enough"), "{comparison}");
    }
    for file in [
        "fit.json",
        "fit.html",
        "fitted.toml",
        "ramp.csv",
        "best.csv",
        "best-run.csv",
    ] {
        assert!(!cli.read(file).is_empty(), "{file}");
    }
}
