//! Whole updates on a model of the flash.

mod images;
mod life;
mod model;
mod power_loss;
mod refused;
mod waiting;

use std::{format, string::String};

use salty::Keypair;

use crate::signature::{DEVELOPMENT_KEY, DEVELOPMENT_SEED};

#[test]
fn the_development_key_is_that_of_its_seed() {
    let keys = Keypair::from(&DEVELOPMENT_SEED);
    assert_eq!(DEVELOPMENT_KEY.0, keys.public.to_bytes());
}

#[test]
fn a_build_with_a_key_of_ones_own_refuses_the_development_key() {
    let digits: String = DEVELOPMENT_KEY
        .0
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    assert!(include_str!("../../build.rs").contains(&digits));
}
