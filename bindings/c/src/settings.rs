//! The model of an actuator and its parameters.
#![allow(
    unsafe_code,
    reason = "functions that C calls by name, with its pointers"
)]
#![allow(
    clippy::missing_safety_doc,
    reason = "the header states the requirements of all pointers once, at its top"
)]

use core::ffi::c_char;

use model_core::actuator::Settings as Core;
use model_core::scenario::{self, NameKind, Request};

use crate::error::{Code, Error, Why, code};
use crate::memory::{self, Holds};
use crate::text::fixed;

/// Words of 8 bytes in `struct actuator_settings`: 824 bytes and room to grow.
pub const ACTUATOR_SETTINGS_WORDS: usize = 128;

/// A model, its plant and the values of their parameters. Opaque; it may be copied by assignment.
#[repr(C)]
pub struct Settings {
    /// Private to the library.
    pub opaque: [u64; ACTUATOR_SETTINGS_WORDS],
}

impl Holds for Settings {
    type Value = Core;
    const MARK: u64 = u64::from_le_bytes(*b"ACTSETT1");
}

/// A row of the parameter table, and the present value.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Present value, in its unit.
    pub value: f64,
    /// Default value, in its unit.
    pub default_value: f64,
    /// Least allowed value, in its unit.
    pub min: f64,
    /// Greatest allowed value, in its unit; infinite without a bound.
    pub max: f64,
    /// Its name.
    pub name: [c_char; 32],
    /// The symbol of the paper; empty if it has none.
    pub symbol: [c_char; 16],
    /// Its unit.
    pub unit: [c_char; 16],
    /// Its meaning, in a sentence.
    pub meaning: [c_char; 192],
    /// The source of the default.
    pub source: [c_char; 128],
}

/// A named interpretation of the paper's numbers.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Preset {
    /// Its name.
    pub name: [c_char; 32],
    /// Its purpose, in a sentence.
    pub summary: [c_char; 192],
    /// The warning that must accompany its results; empty for most.
    pub warning: [c_char; 128],
}

/// Fills `settings` with the defaults of a model. Previous content is overwritten; on failure the
/// settings are not ready.
///
/// `size` is `sizeof *settings`. `model` is `black-box-1`, `black-box-2`, `grey-box` or `board`.
/// `plant` is the plant of the board, `first-order` or `bench`; null is `first-order` for the
/// board, and the only value that other models take.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_init(
    settings: *mut Settings,
    size: usize,
    model: *const c_char,
    plant: *const c_char,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let make = || {
            let model = scenario::named(NameKind::Model, memory::text(model)?)?;
            let plant = match plant.is_null() {
                true => None,
                false => Some(scenario::named(NameKind::Plant, memory::text(plant)?)?),
            };
            let request = Request {
                model: Some(model),
                plant,
                ..Request::default()
            };
            Ok::<_, Error>(request.settings()?)
        };
        memory::explain(memory::fill(settings, size, make), why)
    }
}

/// Sets a parameter of the model and plant, by name or symbol, in its unit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_set(
    settings: *mut Settings,
    name: *const c_char,
    value: f64,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let set = || {
            let settings = memory::change(settings)?;
            Ok(scenario::set(settings, memory::text(name)?, value)?)
        };
        memory::explain(set(), why)
    }
}

/// The present value of a parameter, by name or symbol, in its unit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_get(
    settings: *const Settings,
    name: *const c_char,
    value: *mut f64,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
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

/// Applies a preset of the model by name: it sets some parameters and keeps the others.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_apply(
    settings: *mut Settings,
    preset: *const c_char,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let apply = || {
            let settings = memory::change(settings)?;
            Ok(scenario::apply_preset(settings, memory::text(preset)?)?)
        };
        memory::explain(apply(), why)
    }
}

/// Sets how the bridge of the board is switched: `average` (the default) or
/// `switched`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_set_pwm(
    settings: *mut Settings,
    pwm: *const c_char,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let set = || {
            let settings = memory::change(settings)?;
            settings.pwm = scenario::named(NameKind::Pwm, memory::text(pwm)?)?;
            Ok(())
        };
        memory::explain(set(), why)
    }
}

/// Sets the seed of the random numbers; the default is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_set_seed(settings: *mut Settings, seed: u64) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    code(unsafe { memory::change(settings) }.map(|settings| settings.seed = seed))
}

/// Parameter number `index` of the model and plant; `ACTUATOR_ERROR_NAME` beyond the last.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_parameter(
    settings: *const Settings,
    index: usize,
    parameter: *mut Parameter,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let get = || {
            let found = memory::look(settings)?.values().nth(index);
            memory::put(parameter, found.ok_or(Code::Name)?.into())
        };
        code(get())
    }
}

/// Preset number `index` of the model; `ACTUATOR_ERROR_NAME` beyond the last. Number 0 changes
/// nothing: it is the model without a preset.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_settings_preset(
    settings: *const Settings,
    index: usize,
    preset: *mut Preset,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
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
    fn no_text_of_a_parameter_or_of_a_preset_is_truncated() {
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
