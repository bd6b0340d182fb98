//! Sensors of the board: encoder and analogue front ends with their errors.

pub mod adc;
pub mod board_figures;
pub mod dividers;
pub mod encoder;
pub mod noise;
