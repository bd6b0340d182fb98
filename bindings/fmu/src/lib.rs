//! The actuator as a Functional Mock-up Unit: FMI 2.0 and 3.0 for co-simulation, and for model
//! exchange where the model is continuous.
//!
//! One shared library implements the FMUs of all models. It selects the model by the GUID of the
//! model description, and by `resources/settings.txt` if defaults are changed.
//!
//! | module | is |
//! |---|---|
//! | [`variables`] | the variables of a model, from the parameter tables |
//! | [`description`], [`documentation`], [`archive`] | the FMU as a file |
//! | [`identity`] | the settings of a GUID |
//! | [`instance`] | one instance, in safe Rust: phases, variables, steps, saved states |
//! | [`exchange`] | model exchange: the equations of the continuous models with their events |
//! | [`state`] | the state of an instance and its serialisation |
//! | [`abi`] | the C interfaces of FMI 2.0 and 3.0 around it |
//!
//! "The standard" is FMI for Model Exchange and Co-Simulation 2.0.4, or FMI 3.0.1 in what begins
//! with `fmi3`, <https://fmi-standard.org>.

pub mod abi;
pub mod archive;
pub mod description;
pub mod documentation;
pub mod exchange;
pub mod identity;
pub mod instance;
pub mod state;
pub mod units;
pub mod variables;
