//! The application of the actuator management board.
#![no_std]
