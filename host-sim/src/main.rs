//! `actuator`: the smart actuator on a PC.

fn main() {}
