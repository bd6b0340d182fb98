//! The application of the actuator management board, independent of the hardware.
//!
//! [`application::Application::step`] runs once in each control period: its inputs are the sampled
//! values, its output is the command to the bridge. It runs the control step of `model-core`, as
//! every simulation does. The other modules are further parts of the board's program that a PC can
//! test:
//!
//! | module | contents |
//! |---|---|
//! | [`integrity`] | check of the program's flash |
//! | [`interface`] | inputs, outputs, requests and states that the application shares with its users |
//! | [`application`] | operating states, the control step, requests |
//! | [`bring_up`] | steps of the bring-up of a board, and the ranges of their measurements |
//! | [`command`] | bus, servo pulse and excitation as sources of the commanded angle |
//! | [`measure`] | codes of the converter to mA, mV and degrees Celsius |
//! | [`velocity`] | the velocity that is reported |
//! | [`protection`] | conditions that are monitored in every control period |
//! | [`faults`] | numbered faults, latched and acknowledged |
//! | [`native`] | the application with the simulated board plant |
//! | [`parameters`] | parameters and their ranges |
//! | [`store`] | parameters in flash |
//! | [`capture`] | recording of selected signals at the control rate |
//! | [`shutdown`] | what remains of the program after its data or its flash are corrupt |
//! | [`supervisor`] | supervision of the tasks by the watchdog, missed control periods, cause of the reset |
//! | [`dictionary`] | the CANopen object dictionary |
//! | [`drive`] | the application as a CANopen drive: object dictionary, CiA 402, EMCY, store |
//!
//! Nothing in this crate allocates, blocks, or panics, for any input.

#![no_std]
#![forbid(unsafe_code)]

pub mod application;
pub mod bring_up;
pub mod capture;
pub mod command;
pub mod dictionary;
pub mod drive;
pub mod faults;
pub mod integrity;
pub mod interface;
pub mod measure;
pub mod native;
pub mod parameters;
pub mod protection;
pub mod shutdown;
pub mod store;
pub mod supervisor;
pub mod timing;
pub mod velocity;
