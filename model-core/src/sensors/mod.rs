//! Sensors of the board: encoder and analogue front ends with their errors.

pub mod adc;
pub mod dividers;
pub mod encoder;
pub mod noise;
