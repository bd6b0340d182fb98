//! The application of the actuator management board, free of any hardware.
//!
//! [`application::Application::step`] runs once in each control period of 4 ms: what was sampled
//! goes in, what the bridge shall do comes out. It closes the loop of `model-core`, which every
//! simulation closes too.

#![no_std]
#![forbid(unsafe_code)]

pub mod application;
