mod document;
mod merits;
mod response;

use std::sync::OnceLock;

use super::{
    comparison::{Comparison, Outcome},
    models::MODELS,
};

/// All models on all inputs, simulated once.
fn comparison() -> &'static Comparison {
    static COMPARISON: OnceLock<Comparison> = OnceLock::new();
    COMPARISON.get_or_init(|| Comparison::of(&MODELS, &|| ()).expect("presets are valid"))
}

fn outcome(name: &str) -> &'static Outcome {
    let mut outcomes = comparison().outcomes.iter();
    outcomes.find(|o| o.runs.model.name == name).expect(name)
}
