//! What an actuator is made of.
#![allow(
    unsafe_code,
    reason = "functions that C calls by name, with its pointers"
)]
#![allow(
    clippy::missing_safety_doc,
    reason = "what every pointer must be stands once, at the top of the header"
)]

use core::ffi::c_char;

use model_core::actuator::Settings as Core;
use model_core::scenario::{self, Kind, Request};

use crate::error::{Code, Error, Why, code, explain};
use crate::memory::{self, Holds};
use crate::text::fixed;

/// Words of 8 bytes in `struct actuator_settings`: 824 bytes and room to grow.
pub const ACTUATOR_SETTINGS_WORDS: usize = 128;

/// A model, its plant and the values of their parameters. Opaque; it may be copied by assignment.
#[repr(C)]
pub struct Settings {
    /// Not for the caller.
    pub opaque: [u64; ACTUATOR_SETTINGS_WORDS],
}

impl Holds for Settings {
    type Value = Core;
    const MARK: u64 = u64::from_le_bytes(*b"ACTSETT1");
}

/// What is known of one parameter, and its present value.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Present value, in its unit.
    pub value: f64,
    /// Value unless somebody says otherwise, in its unit.
    pub default_value: f64,
    /// The least value that it takes, in its unit.
    pub min: f64,
    /// The greatest value that it takes, in its unit; infinite where there is no bound.
    pub max: f64,
    /// Its name.
    pub name: [c_char; 32],
    /// The short symbol of the paper; empty where there is none.
    pub symbol: [c_char; 16],
    /// Its unit.
    pub unit: [c_char; 16],
    /// What it is, in a sentence.
    pub meaning: [c_char; 192],
    /// Where the default comes from.
    pub source: [c_char; 128],
}

/// A named reading of the paper's numbers.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Preset {
    /// Its name.
    pub name: [c_char; 32],
    /// What it is for, in a sentence.
    pub summary: [c_char; 192],
    /// What must be said wherever its results are shown; empty for most.
    pub warning: [c_char; 128],
}

/// Fills `settings` with the defaults of a model; whatever was there is overwritten, and where it
/// fails the settings are not ready.
///
/// `size` is `sizeof *settings`. `model` is `black-box-1`, `black-box-2`, `grey-box` or `board`.
/// `plant` is the plant behind the board, `first-order` or `bench`; null is `first-order` for the
/// board, and the only value that other models take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_init(
    settings: *mut Settings,
    size: usize,
    model: *const c_char,
    plant: *const c_char,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header wants them.
    unsafe {
        let make = || {
            let model = scenario::named(Kind::Model, memory::text(model)?)?;
            let plant = match plant.is_null() {
                true => None,
                false => Some(scenario::named(Kind::Plant, memory::text(plant)?)?),
            };
            let request = Request {
                model: Some(model),
                plant,
                ..Request::default()
            };
            Ok::<_, Error>(request.settings()?)
        };
        explain(memory::fill(settings, size, make), why)
    }
}

/// Sets a parameter of the chosen model and plant, by name or by symbol, in its unit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_set(
    settings: *mut Settings,
    name: *const c_char,
    value: f64,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header wants them.
    unsafe {
        let set = || {
            let settings = memory::change(settings)?;
            Ok(scenario::set(settings, memory::text(name)?, value)?)
        };
        explain(set(), why)
    }
}

/// The present value of a parameter, by name or by symbol, in its unit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_get(
    settings: *const Settings,
    name: *const c_char,
    value: *mut f64,
) -> Code {
    // SAFETY: the caller's pointers, as the header wants them.
    unsafe {
        let get = || {
            let (settings, name) = (memory::look(settings)?, memory::text(name)?);
            let mut values = settings.values();
            let found = values.find(|v| v.parameter.is_called(name));
            memory::put(value, found.ok_or(Code::Name)?.value)
        };
        code(get())
    }
}

/// Applies a preset of the chosen model by name: it sets some parameters and leaves the others.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_apply(
    settings: *mut Settings,
    preset: *const c_char,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header wants them.
    unsafe {
        let apply = || {
            let settings = memory::change(settings)?;
            Ok(scenario::apply_preset(settings, memory::text(preset)?)?)
        };
        explain(apply(), why)
    }
}

/// How the bridge of the board is switched: `average` (unless somebody says otherwise) or
/// `switched`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_set_pwm(
    settings: *mut Settings,
    pwm: *const c_char,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header wants them.
    unsafe {
        let set = || {
            let settings = memory::change(settings)?;
            settings.pwm = scenario::named(Kind::Pwm, memory::text(pwm)?)?;
            Ok(())
        };
        explain(set(), why)
    }
}

/// The seed of all that is random; 0 unless somebody says otherwise.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_set_seed(settings: *mut Settings, seed: u64) -> Code {
    // SAFETY: the caller's pointers, as the header wants them.
    code(unsafe { memory::change(settings) }.map(|settings| settings.seed = seed))
}

/// Parameter number `index` of the chosen model and plant; `ACTUATOR_ERROR_NAME` beyond the last.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_parameter(
    settings: *const Settings,
    index: usize,
    parameter: *mut Parameter,
) -> Code {
    // SAFETY: the caller's pointers, as the header wants them.
    unsafe {
        let get = || {
            let found = memory::look(settings)?.values().nth(index);
            memory::put(parameter, found.ok_or(Code::Name)?.into())
        };
        code(get())
    }
}

/// Preset number `index` of the chosen model; `ACTUATOR_ERROR_NAME` beyond the last. Number 0
/// changes nothing: it is what the model is without a preset.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_preset(
    settings: *const Settings,
    index: usize,
    preset: *mut Preset,
) -> Code {
    // SAFETY: the caller's pointers, as the header wants them.
    unsafe {
        let get = || {
            let found = memory::look(settings)?.model.presets().nth(index);
            memory::put(preset, found.ok_or(Code::Name)?.into())
        };
        code(get())
    }
}

impl From<model_core::parameter::Value> for Parameter {
    fn from(value: model_core::parameter::Value) -> Self {
        let p = value.parameter;
        Self {
            value: value.value,
            default_value: p.default,
            min: p.min,
            max: p.max,
            name: fixed(p.name),
            symbol: fixed(p.symbol),
            unit: fixed(p.unit),
            meaning: fixed(p.meaning),
            source: fixed(p.source),
        }
    }
}

impl From<&model_core::presets::Preset> for Preset {
    fn from(preset: &model_core::presets::Preset) -> Self {
        Self {
            name: fixed(preset.name),
            summary: fixed(preset.summary),
            warning: fixed(preset.warning.unwrap_or_default()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_text_of_a_parameter_or_of_a_preset_is_cut() {
        for settings in scenario::choices() {
            for value in settings.values() {
                let p = value.parameter;
                let room = [
                    (p.name, 32),
                    (p.symbol, 16),
                    (p.unit, 16),
                    (p.meaning, 192),
                    (p.source, 128),
                ];
                assert!(room.iter().all(|(text, room)| text.len() < *room), "{p:?}");
            }
        }
        for p in model_core::presets::PRESETS {
            let room = [
                (p.name, 32),
                (p.summary, 192),
                (p.warning.unwrap_or_default(), 128),
            ];
            assert!(room.iter().all(|(text, room)| text.len() < *room), "{p:?}");
        }
    }

    #[test]
    fn the_first_preset_of_every_model_changes_nothing() {
        for settings in scenario::choices() {
            assert_eq!(
                settings.model.presets().next().map(|p| p.values),
                Some([].as_slice())
            );
        }
    }
}
