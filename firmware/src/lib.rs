//! The application of the actuator management board, free of any hardware.
//!
//! [`application::Application::step`] runs once in each control period of 4 ms: what was sampled
//! goes in, what the bridge shall do comes out. The same code runs on the board and in every
//! simulation.

#![no_std]

pub mod application;
