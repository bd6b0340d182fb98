//! The application of the actuator management board, free of any hardware.
//!
//! [`application::Application::step`] runs once in each control period: what was sampled
//! goes in, what the bridge shall do comes out. It closes the loop of `model-core`, which every
//! simulation closes too. Beside it stands what else a board needs and a PC can test:
//!
//! | module | is |
//! |---|---|
//! | [`interface`] | inputs, outputs, requests and states that the application shares with its users |
//! | [`application`] | operating states, the control step, requests |
//! | [`command`] | bus, servo pulse and excitation as sources of the commanded angle |
//! | [`measure`] | codes of the converter to mA, mV and degrees Celsius |
//! | [`protection`] | what is watched in every control period |
//! | [`faults`] | numbered faults, latched and acknowledged |
//! | [`native`] | the application around the simulated rig |
//! | [`parameters`] | everything that can be set, its ranges |
//! | [`store`] | parameters in flash |
//! | [`capture`] | chosen signals at the control rate into a buffer |
//! | [`supervisor`] | when the watchdog is fed, missed control periods, cause of the reset |
//! | [`dictionary`] | the CANopen object dictionary |
//! | [`drive`] | the application as a CANopen drive: object dictionary, CiA 402, EMCY, store |
//!
//! Nothing here allocates, blocks, or panics, whatever comes in.

#![no_std]
#![forbid(unsafe_code)]

pub mod application;
pub mod capture;
pub mod command;
pub mod dictionary;
pub mod drive;
pub mod faults;
pub mod interface;
pub mod measure;
pub mod native;
pub mod parameters;
pub mod protection;
pub mod store;
pub mod supervisor;
pub mod timing;
