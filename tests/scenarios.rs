//! The front ends accept and refuse the same scenarios, those of `scenarios.txt`.
//!
//! The command line, C and Python read the same file in their own tests.

use actuator_fmu::identity;
use model_core::actuator::Actuator;
use model_core::scenario::{Request, Scenario};

/// A scenario, and whether it is accepted.
struct Case {
    is_accepted: bool,
    text: &'static str,
}

impl Case {
    fn all() -> impl Iterator<Item = Self> {
        let lines = include_str!("scenarios.txt").lines();
        let lines = lines.filter(|line| !line.starts_with('#'));
        lines.map(|line| {
            let (verdict, text) = line.split_once(' ').expect("a verdict and a scenario");
            assert!(["accept", "refuse"].contains(&verdict), "{line}");
            Self {
                is_accepted: verdict == "accept",
                text,
            }
        })
    }

    fn entries(&self) -> impl Iterator<Item = (&'static str, &'static str)> {
        let entries = self.text.split('&');
        entries.map(|entry| entry.split_once('=').expect("key=value"))
    }

    fn value(&self, key: &str) -> Option<&'static str> {
        self.entries().find(|entry| entry.0 == key).map(|e| e.1)
    }

    #[track_caller]
    fn check<E: ToString>(&self, front_end: &str, result: Result<(), E>) {
        let error = result.err().map(|error| error.to_string());
        assert_eq!(
            error.is_none(),
            self.is_accepted,
            "{front_end}: {}: {error:?}",
            self.text
        );
    }
}

#[test]
fn the_core_decides() {
    for case in Case::all() {
        let run = || -> Result<(), String> {
            let mut request = Request::default();
            let mut parameters = Vec::new();
            for (key, value) in case.entries() {
                if !request.parse(key, value).map_err(|e| e.to_string())? {
                    parameters.push((key, value.parse().map_err(|_| "no number")?));
                }
            }
            let mut scenario = Scenario::try_new(&request).map_err(|e| e.to_string())?;
            for (name, value) in parameters {
                scenario.set(name, value).map_err(|e| e.to_string())?;
            }
            scenario.input.excitation().map_err(|e| e.to_string())?;
            let actuator = Actuator::try_new(&scenario.settings);
            actuator.map(drop).map_err(|e| e.to_string())
        };
        case.check("core", run());
    }
}

#[test]
fn a_scenario_file_follows_the_core() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scenario.toml");
    for case in Case::all() {
        let (mut options, mut parameters) = (String::new(), String::from("[set]\n"));
        for (key, value) in case.entries() {
            match key {
                "duration_s" | "every" | "seed" => options += &format!("{key} = {value}\n"),
                key if Request::OPTIONS.contains(&key) => {
                    options += &format!("{key} = \"{value}\"\n");
                }
                key => parameters += &format!("\"{key}\" = {value}\n"),
            }
        }
        std::fs::write(&path, options + &parameters).expect("the folder takes it");
        let scenario = host_sim::scenario::Scenario::read(&path);
        let simulation = scenario.and_then(|scenario| scenario.resolve());
        case.check("scenario file", simulation.map(drop));
    }
}

#[test]
fn a_page_follows_the_core() {
    for case in Case::all() {
        let trace = actuator_web::scenario::Scenario::parse(case.text)
            .and_then(|scenario| actuator_web::run::run(&scenario, |_| true));
        case.check("page", trace.map(drop));
    }
}

#[test]
fn an_fmu_follows_the_core() {
    let left_out = ["preset", "input", "duration_s", "every"];
    let is_fmu = |case: &Case| {
        let is_board = case.value("model") == Some("board");
        let mut keys = case.entries().map(|entry| entry.0);
        // The file of an FMU has a line for the plant of every model.
        keys.all(|key| {
            !key.starts_with("input.") && !left_out.contains(&key) && (is_board || key != "plant")
        })
    };
    let mut count = 0;
    for case in Case::all().filter(is_fmu) {
        let option = |name, default| format!("{name} {}\n", case.value(name).unwrap_or(default));
        let mut text = option("model", "") + &option("plant", "first-order");
        text += &(option("pwm", "average") + &option("seed", "0"));
        for (key, value) in case.entries() {
            if !Request::OPTIONS.contains(&key) {
                text += &format!("{key} {value}\n");
            }
        }
        let settings = identity::from_text(&text);
        let actuator = settings.and_then(|s| Actuator::try_new(&s).map_err(|e| e.to_string()));
        case.check("FMU", actuator.map(drop));
        count += 1;
    }
    assert!(count > 10);
}
