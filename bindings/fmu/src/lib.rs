//! The actuator as a Functional Mock-up Unit: FMI 2.0 for co-simulation.
//!
//! One shared library serves the FMUs of all models. It learns which one it is from the GUID of the
//! model description, and from `resources/settings.txt` where the defaults were changed.
//!
//! | module | is |
//! |---|---|
//! | [`variables`] | what a model shows to its host, made from the parameter tables |
//! | [`description`], [`documentation`], [`archive`] | the FMU as a file |
//! | [`identity`] | which settings belong to a GUID |
//! | [`instance`] | one instance, in safe Rust: phases, variables, steps, kept states |
//! | [`state`] | everything an instance remembers, as bytes too |
//! | [`abi`] | the C interface around it |
//!
//! "The standard" is FMI for Model Exchange and Co-Simulation 2.0.4, <https://fmi-standard.org>.

pub mod abi;
pub mod archive;
pub mod description;
pub mod documentation;
pub mod identity;
pub mod instance;
pub mod state;
pub mod units;
pub mod variables;
