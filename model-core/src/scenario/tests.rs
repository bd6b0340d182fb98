use super::*;
use std::string::ToString;

fn parsed<'a>(options: &[(&'a str, &'a str)]) -> Result<Scenario, ScenarioError<'a>> {
    let mut request = Request::default();
    for (option, value) in options {
        assert!(request.parse(option, value)?, "{option}");
    }
    Scenario::try_new(&request)
}

#[test]
fn every_option_is_parsed_under_its_name() {
    let values = [
        "board",
        "bench",
        "consistent",
        "chirp",
        "0.25",
        "7",
        "3",
        "switched",
    ];
    let options: std::vec::Vec<_> = Request::OPTIONS.into_iter().zip(values).collect();
    let scenario = parsed(&options).unwrap();
    let settings = scenario.settings;
    assert_eq!(
        (settings.model, settings.plant),
        (ModelKind::Board, PlantKind::Drivetrain)
    );
    assert_eq!((settings.seed, settings.pwm), (3, Pwm::Switched));
    assert_eq!((scenario.input.name(), scenario.every), ("chirp", 7));
    assert_eq!(scenario.ticks(), Ok(5000));
    assert_eq!(Request::default().parse("position_gain", "1"), Ok(false));
}

#[test]
fn the_default_duration_is_that_of_the_input_and_the_shortest_is_one_tick() {
    let pulse = parsed(&[("model", "grey-box")]).unwrap();
    assert_eq!(pulse.ticks(), Ok(100_000));
    let short = parsed(&[("model", "grey-box"), ("duration_s", "1e-9")]).unwrap();
    assert_eq!(short.ticks(), Ok(1));
}

#[test]
fn an_error_names_the_invalid_value_and_the_expected_ones() {
    let board = ("model", "board");
    let cases: [(&[(&str, &str)], &str); 11] = [
        (
            &[],
            "no model, expected one of black-box-1, black-box-2, grey-box, board",
        ),
        (
            &[("model", "bord")],
            "unknown model `bord`; expected black-box-1, black-box-2, grey-box, board",
        ),
        (
            &[board, ("pwm", "on")],
            "unknown pwm `on`; expected average, switched",
        ),
        (
            &[("model", "black-box-1"), ("preset", "papr")],
            "unknown preset `papr`; expected paper",
        ),
        (
            &[("model", "grey-box"), ("plant", "bench")],
            "`plant` applies to the model `board`, `grey-box` has no plant",
        ),
        (
            &[("model", "black-box-1"), ("preset", "asymmetric")],
            "preset `asymmetric` is for grey-box and board, not for black-box-1: as consistent, \
             with motor gains of 2.40 up and 3.50 down; expected paper",
        ),
        (
            &[board, ("plant", "bench"), ("preset", "asymmetric")],
            "preset `asymmetric` sets parameters of the plant `first-order`; the plant is `bench`",
        ),
        (
            &[board, ("duration_s", "NaN")],
            "duration is NaN, expected more than 0 and at most 10,000,000 s",
        ),
        (
            &[board, ("every", "0")],
            "every is 0, expected at least 1 tick",
        ),
        (
            &[board, ("every", "1.5")],
            "every is `1.5`, expected a whole number that is not negative",
        ),
        (
            &[board, ("duration_s", "soon")],
            "duration_s is `soon`, expected a number",
        ),
    ];
    for (options, message) in cases {
        assert_eq!(parsed(options).unwrap_err().to_string(), message);
    }
}

#[test]
fn a_parameter_is_set_by_name_or_symbol_and_a_refused_one_changes_nothing() {
    let mut scenario = parsed(&[("model", "board"), ("input", "sine")]).unwrap();
    scenario.set("P", 9.0).unwrap();
    scenario.set("input.amplitude_deg", 3.0).unwrap();
    let before = scenario;
    let refused = [
        (
            "gian",
            "unknown parameter `gian`; expected a parameter of the model board",
        ),
        (
            "P",
            "parameter position_gain is -1, expected a number from 0 to 500 1/s",
        ),
        (
            "input.amplitude",
            "unknown input parameter `amplitude`; expected input.amplitude_deg, input.frequency_hz",
        ),
        (
            "input.frequency_hz",
            "parameter input.frequency_hz is -1, expected a number from",
        ),
    ];
    for (name, message) in refused {
        let error = scenario.set(name, -1.0).unwrap_err().to_string();
        assert!(error.starts_with(message), "{error}");
    }
    assert_eq!(scenario, before);
    let value = |is_of_input, name| {
        let mut values = scenario.values();
        let found =
            values.find(|(of_input, v)| *of_input == is_of_input && v.parameter.name == name);
        found.map(|(_, v)| v.value)
    };
    assert_eq!(value(false, "position_gain"), Some(9.0));
    assert_eq!(value(true, "amplitude_deg"), Some(3.0));
}

#[test]
fn each_model_and_plant_is_listed_once_with_its_presets() {
    assert_eq!(choices().count(), 5);
    for settings in choices() {
        assert!(presets(&settings).count() > 0);
        for preset in settings.model.presets() {
            let applies = apply_preset(&mut settings.clone(), preset.name).is_ok();
            assert_eq!(applies, presets(&settings).any(|p| p == preset));
        }
    }
}
