//! The program of the actuator management board, independent of the hardware, in two halves.
//!
//! The **loop** decides everything that moves the shaft, once in each control period, and knows no
//! bus: [`control_loop::Loop::step`] makes the state of the bridge of samples, commands and
//! parameters. It runs the control step of `model-core`, as every simulation does.
//!
//! | module | contents |
//! |---|---|
//! | [`control_loop`] | the loop: commands, axis, reaction to the loss of the master |
//! | [`application`] | operating states, stops, the control step |
//! | [`interface`] | inputs, outputs, requests and states |
//! | [`command`] | bus, servo pulse and excitation as sources of the commanded angle |
//! | [`measure`] | codes of the converter to mA, mV and degrees Celsius |
//! | [`velocity`] | the velocity that is reported |
//! | [`protection`] | conditions that are monitored in every control period |
//! | [`faults`] | numbered faults, latched and acknowledged |
//! | [`replicated`] | two copies of the loop, compared; the shutdown after a difference |
//!
//! The **communication** posts messages to the loop and reads its outputs; it is preempted by the
//! loop.
//!
//! | module | contents |
//! |---|---|
//! | [`check_value`] | messages between both halves, with check values |
//! | [`drive`] | the loop as a CANopen drive: object dictionary, EMCY, store |
//! | [`dictionary`] | the CANopen object dictionary |
//! | [`capture`] | recording of selected signals at the control rate |
//! | [`parameters`] | parameters and their ranges |
//! | [`store`] | parameters in flash |
//!
//! | module | contents, for both |
//! |---|---|
//! | [`actuator`] | both halves on a PC, in the order of the board |
//! | [`native`] | samples and bridge of the simulated board plant |
//! | [`bring_up`] | steps of the bring-up of a board, and the ranges of their measurements |
//! | [`integrity`] | check of the program's flash |
//! | [`supervisor`] | supervision of the tasks by the watchdog, missed control periods, cause of the reset |
//! | [`timing`] | times in control periods, and quantities in thousandths |
//!
//! Nothing in this crate allocates, blocks, or panics, for any input.

#![no_std]
#![forbid(unsafe_code)]

pub mod actuator;
pub mod application;
pub mod bring_up;
pub mod capture;
pub mod check_value;
pub mod command;
pub mod control_loop;
pub mod dictionary;
pub mod drive;
pub mod faults;
pub mod health;
pub mod integrity;
pub mod interface;
pub mod measure;
pub mod native;
pub mod parameters;
pub mod protection;
pub mod replicated;
pub mod store;
pub mod supervisor;
pub mod timing;
pub mod velocity;
