//! Presets: named readings of the paper.
//!
//! The paper's numbers contradict each other: a motor gain of 2.836/7.586 gives 37.4 deg/s at full
//! duty where +240 and -350 deg/s were measured. Each preset is one reading of them, as changes to
//! the defaults of the parameter tables. The grey box and the board have parameters of the same
//! names and share presets; presets that differ are separate entries.

/// A named set of parameter values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// Name, as on the command line.
    pub name: &'static str,
    /// Description in one sentence.
    pub summary: &'static str,
    /// Warning to show with its results.
    pub warning: Option<&'static str>,
    /// Models to which it applies.
    pub models: &'static [&'static str],
    /// Parameters that differ from their defaults, by name.
    pub values: &'static [(&'static str, f64)],
}

/// DC gain of equation (2) as printed, 2.836/(s + 7.586): (deg/s)/%.
const PRINTED_MOTOR_GAIN: f64 = 2.836 / 7.586;

/// Integral gain of equation (1) as printed, 10 (1 + 0.1318 s)/(0.13182 s), where 0.13182 is
/// 1/7.586: %/deg.
const PRINTED_INTEGRAL_GAIN: f64 = 10.0 * 7.586;

/// Bandwidth of the rate loop of `as-measured-retuned`: the inner gain of black box 2, rad/s.
const RETUNED_RATE_LOOP_RAD_S: f64 = 54.0;

/// Motor gain for which `as-measured-retuned` is designed: the harmonic mean of 2.40 and 3.50,
/// (deg/s)/%.
const MEAN_MOTOR_GAIN: f64 = 2.0 / (1.0 / 2.40 + 1.0 / 3.50);

const BLACK_BOXES: &[&str] = &["black-box-1", "black-box-2"];
const GREY_BOX: &[&str] = &["grey-box"];
const GREY_BOX_AND_BOARD: &[&str] = &["grey-box", "board"];

/// All presets. The first that applies to a model is that model's default.
pub const PRESETS: &[Preset] = &[
    Preset {
        name: "paper",
        summary: "the black boxes with the paper's numbers, which are consistent",
        warning: None,
        models: BLACK_BOXES,
        values: &[],
    },
    Preset {
        name: "consistent",
        summary: "G = 2.836/(1 + 0.1318 s), F = 10 (1 + 0.1318 s)/s: the printed loop, 283.6 deg/s",
        warning: None,
        models: GREY_BOX_AND_BOARD,
        values: &[],
    },
    Preset {
        name: "asymmetric",
        summary: "as consistent, with motor gains of 2.40 up and 3.50 down",
        warning: None,
        models: GREY_BOX_AND_BOARD,
        values: &[("motor_gain_up", 2.40), ("motor_gain_down", 3.50)],
    },
    Preset {
        name: "as-measured",
        summary: "a motor that reaches +240 and -350 deg/s with a lag of 1/54 s, the default gains",
        warning: None,
        models: GREY_BOX_AND_BOARD,
        values: &[
            ("motor_gain_up", 2.40),
            ("motor_gain_down", 3.50),
            ("motor_time_constant_s", 1.0 / 54.0),
        ],
    },
    Preset {
        name: "as-measured-retuned",
        summary: "the motor of as-measured, rate loop 54 rad/s, position loop 16.67/s",
        warning: None,
        models: GREY_BOX_AND_BOARD,
        // The zero of the PI cancels the motor's pole, Kp/Ki = tau, which leaves F G = Ki K/s =
        // 54/s; Kaw = 1/Ti = 1/tau. P = A/B of black box 2 makes the linear loop equal to it.
        values: &[
            ("motor_gain_up", 2.40),
            ("motor_gain_down", 3.50),
            ("motor_time_constant_s", 1.0 / 54.0),
            (
                "proportional_gain",
                RETUNED_RATE_LOOP_RAD_S / 54.0 / MEAN_MOTOR_GAIN,
            ),
            ("integral_gain", RETUNED_RATE_LOOP_RAD_S / MEAN_MOTOR_GAIN),
            ("anti_windup_gain", 54.0),
            ("position_gain", 900.0 / 54.0),
        ],
    },
    Preset {
        name: "as-printed",
        summary: "G and F as printed, duty in the paper's unit and unlimited, which no board can realise; \
                  rate limited to +240 and -350 deg/s; the anti-windup gain of 2 is this project's choice",
        warning: None,
        models: GREY_BOX,
        values: &[
            ("motor_gain_up", PRINTED_MOTOR_GAIN),
            ("motor_gain_down", PRINTED_MOTOR_GAIN),
            ("proportional_gain", 10.0),
            ("integral_gain", PRINTED_INTEGRAL_GAIN),
            ("anti_windup_gain", 0.0),
            ("rate_anti_windup_gain", 2.0),
            ("duty_limit_pct", f64::INFINITY),
            ("rate_limit_up_deg_s", 240.0),
            ("rate_limit_down_deg_s", 350.0),
        ],
    },
    Preset {
        name: "as-printed-strict",
        summary: "G and F as printed, duty limited to 100 %; the sampled board has a limit cycle at this gain",
        warning: Some("37.4 deg/s: contradicts the paper's own rate limits"),
        models: GREY_BOX_AND_BOARD,
        values: &[
            ("motor_gain_up", PRINTED_MOTOR_GAIN),
            ("motor_gain_down", PRINTED_MOTOR_GAIN),
            ("proportional_gain", 10.0),
            ("integral_gain", PRINTED_INTEGRAL_GAIN),
            ("rate_limit_up_deg_s", 240.0),
            ("rate_limit_down_deg_s", 350.0),
        ],
    },
];

/// The preset with this name.
///
/// ```
/// let strict = model_core::presets::preset("as-printed-strict").unwrap();
/// assert!(strict.warning.unwrap().starts_with("37.4 deg/s"));
/// assert!(strict.values.contains(&("proportional_gain", 10.0)));
/// assert_eq!(model_core::presets::preset("as printed"), None);
/// ```
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

#[cfg(test)]
mod tests {
    use super::{PRESETS, preset};
    use crate::control::parameters::ControlParameters;
    use crate::models::black_box_1::BlackBox1Parameters;
    use crate::models::black_box_2::BlackBox2Parameters;
    use crate::models::grey_box::GreyBoxParameters;
    use crate::parameter::{Parameter, Parameters};
    use crate::plant::first_order::FirstOrderParameters;
    use std::vec::Vec;

    fn tables(model: &str) -> Vec<Parameter> {
        match model {
            "black-box-1" => BlackBox1Parameters::TABLE.to_vec(),
            "black-box-2" => BlackBox2Parameters::TABLE.to_vec(),
            "grey-box" => GreyBoxParameters::TABLE.to_vec(),
            "board" => [ControlParameters::TABLE, FirstOrderParameters::TABLE].concat(),
            _ => panic!("no model is called {model}"),
        }
    }

    #[test]
    fn each_preset_sets_known_parameters_of_its_models_within_their_ranges() {
        for preset in PRESETS {
            for model in preset.models {
                let table = tables(model);
                for (name, value) in preset.values {
                    let of_this_name: Vec<_> = table.iter().filter(|p| p.name == *name).collect();
                    assert_eq!(of_this_name.len(), 1, "{}: {model}: {name}", preset.name);
                    assert!(of_this_name[0].check(*value).is_ok(), "{name} = {value}");
                }
            }
        }
    }

    #[test]
    fn names_are_unique_and_each_model_has_a_default_without_changes() {
        for (i, one) in PRESETS.iter().enumerate() {
            assert!(PRESETS[..i].iter().all(|other| other.name != one.name));
        }
        for model in ["black-box-1", "black-box-2", "grey-box", "board"] {
            let default = PRESETS.iter().find(|p| p.models.contains(&model)).unwrap();
            assert!(default.values.is_empty(), "{model}");
        }
    }

    #[test]
    fn the_motor_as_printed_reaches_37_4_deg_s_and_as_measured_the_papers_limits() {
        let value = |name: &str, parameter: &str| {
            let values = preset(name).unwrap().values;
            values.iter().find(|(p, _)| *p == parameter).unwrap().1
        };
        assert!((100.0 * value("as-printed-strict", "motor_gain_up") - 37.4).abs() < 0.05);
        assert_eq!(100.0 * value("as-measured", "motor_gain_up"), 240.0);
        assert_eq!(100.0 * value("as-measured", "motor_gain_down"), 350.0);
    }

    #[test]
    fn retuned_to_the_measured_motor_the_rate_loop_is_54_over_s() {
        let mut parameters = GreyBoxParameters::default();
        for (name, value) in preset("as-measured-retuned").unwrap().values {
            parameters.set(name, *value).unwrap();
        }
        let p = parameters;
        let motor_gain =
            2.0 * p.motor_gain_up * p.motor_gain_down / (p.motor_gain_up + p.motor_gain_down);
        assert!((p.integral_gain * motor_gain - 54.0).abs() < 1e-12);
        let zero_s = p.proportional_gain / p.integral_gain;
        assert!((zero_s - p.motor_time_constant_s).abs() < 1e-15);
        assert!((p.anti_windup_gain * p.motor_time_constant_s - 1.0).abs() < 1e-15);
        assert!((p.position_gain - 16.67).abs() < 0.005);
    }
}
