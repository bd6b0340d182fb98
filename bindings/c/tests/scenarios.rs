//! The C library accepts and refuses the scenarios that every front end does.
#![allow(unsafe_code, reason = "calls the library as C does")]

use std::ffi::CString;
use std::ptr::null;

use actuator_c::actuator::{ACTUATOR_WORDS, Actuator, actuator_start};
use actuator_c::error::{Code, Why};
use actuator_c::settings::{
    ACTUATOR_SETTINGS_WORDS, Settings, actuator_settings_apply, actuator_settings_init,
    actuator_settings_set, actuator_settings_set_pwm, actuator_settings_set_seed,
};

const CASES: &str = include_str!("../../../tests/scenarios.txt");

/// Keys that do not exist in C, where the caller sets the commands and steps.
const LEFT_OUT: [&str; 3] = ["input", "duration_s", "every"];

fn text(value: &str) -> CString {
    CString::new(value).unwrap()
}

fn run(entries: &[(&str, &str)]) -> Code {
    let value = |key: &str| entries.iter().find(|e| e.0 == key).map(|e| text(e.1));
    let pointer = |text: &Option<CString>| text.as_ref().map_or(null(), |text| text.as_ptr());
    let (model, plant) = (value("model"), value("plant"));
    let (preset, pwm) = (value("preset"), value("pwm"));
    let mut settings = Settings {
        opaque: [0; ACTUATOR_SETTINGS_WORDS],
    };
    let mut actuator = Box::new(Actuator {
        opaque: [0; ACTUATOR_WORDS],
    });
    let why: *mut Why = std::ptr::null_mut();
    let size = size_of::<Settings>();
    // SAFETY: every pointer is null or one of this function's values, and texts end in a zero.
    unsafe {
        let made =
            actuator_settings_init(&mut settings, size, pointer(&model), pointer(&plant), why);
        let mut codes = vec![made];
        if preset.is_some() {
            codes.push(actuator_settings_apply(
                &mut settings,
                pointer(&preset),
                why,
            ));
        }
        if pwm.is_some() {
            codes.push(actuator_settings_set_pwm(&mut settings, pointer(&pwm), why));
        }
        for (key, value) in entries {
            let code = match *key {
                "model" | "plant" | "preset" | "pwm" => continue,
                "seed" => match value.parse() {
                    Ok(seed) => actuator_settings_set_seed(&mut settings, seed),
                    // The type of the argument refuses it.
                    Err(_) => Code::Parameter,
                },
                key => {
                    let (name, value) = (text(key), value.parse().unwrap());
                    actuator_settings_set(&mut settings, name.as_ptr(), value, why)
                }
            };
            codes.push(code);
        }
        codes.push(actuator_start(
            &mut *actuator,
            size_of::<Actuator>(),
            &settings,
            why,
        ));
        let failed = codes.into_iter().find(|code| *code != Code::None);
        failed.unwrap_or(Code::None)
    }
}

#[test]
fn the_scenarios_of_every_front_end_are_accepted_and_refused() {
    let mut count = 0;
    for line in CASES.lines().filter(|line| !line.starts_with('#')) {
        let (verdict, scenario) = line.split_once(' ').unwrap();
        let entries = scenario
            .split('&')
            .map(|entry| entry.split_once('=').unwrap());
        let entries: Vec<_> = entries.collect();
        let is_left_out = |key: &str| key.starts_with("input.") || LEFT_OUT.contains(&key);
        if entries.iter().any(|entry| is_left_out(entry.0)) {
            continue;
        }
        let code = run(&entries);
        assert_eq!(code == Code::None, verdict == "accept", "{line}: {code:?}");
        count += 1;
    }
    assert!(count > 10);
}
