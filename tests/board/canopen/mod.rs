//! The program that speaks CANopen.

mod bit_exact;
mod bus;
mod costs;
mod faults;
