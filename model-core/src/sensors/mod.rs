//! What the board sees of the plant: encoder and analogue front ends with their errors.

pub mod adc;
pub mod dividers;
pub mod encoder;
pub mod noise;
