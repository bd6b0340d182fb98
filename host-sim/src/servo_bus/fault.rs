//! Faults of servos and their line, as lines of text.

use std::str::FromStr;

use super::bus::Bus;

/// A fault, or its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// The supply has this voltage, V.
    Supply(f64),
    /// Of one servo, by its place on the line from 1 on.
    Of(usize, OfServo),
}

/// A fault of a servo, or its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OfServo {
    /// The gears are jammed, or not.
    Jam(bool),
    /// This torque acts on the shaft, Nm.
    Load(f64),
    /// The servo is not on the line, or is again.
    Absent(bool),
    /// One bit of each of its next answers is wrong.
    Corrupt(u32),
    /// It has this ID.
    Id(u8),
}

/// A line that names no fault.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "fault `{0}`: expected `supply VOLTS`, or the number of a servo and one of `jam`, `free`, \
     `load NM`, `vanish`, `return`, `corrupt ANSWERS`, `id ID`"
)]
pub struct NoFault(String);

impl FromStr for Fault {
    type Err = NoFault;

    fn from_str(line: &str) -> Result<Self, NoFault> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let refuse = || NoFault(line.trim().to_owned());
        let real = |word: &str| word.parse().ok().filter(|value: &f64| value.is_finite());
        let fault = match *words {
            ["supply", volts] => real(volts)
                .filter(|volts| (0.0..=60.0).contains(volts))
                .map(Self::Supply),
            [servo, ref what @ ..] => {
                let fault = match *what {
                    ["jam"] => Some(OfServo::Jam(true)),
                    ["free"] => Some(OfServo::Jam(false)),
                    ["load", torque] => real(torque).map(OfServo::Load),
                    ["vanish"] => Some(OfServo::Absent(true)),
                    ["return"] => Some(OfServo::Absent(false)),
                    ["corrupt", answers] => answers.parse().ok().map(OfServo::Corrupt),
                    ["id", id] => id.parse().ok().filter(|id| *id <= 252).map(OfServo::Id),
                    _ => None,
                };
                let servo = servo.parse().ok().filter(|servo| *servo > 0);
                servo
                    .zip(fault)
                    .map(|(servo, fault)| Self::Of(servo, fault))
            }
            [] => None,
        };
        fault.ok_or_else(refuse)
    }
}

impl Bus {
    /// Begins or ends a fault; of a servo that does not exist, nothing.
    pub fn apply(&mut self, fault: Fault) {
        match fault {
            Fault::Supply(volts) => self.set_supply_v(volts),
            Fault::Of(place, fault) => {
                if let Some(servo) = self.servos().get_mut(place - 1) {
                    servo.apply(fault);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Fault, OfServo};

    #[test]
    fn lines_name_faults_or_are_refused() {
        let lines = [
            ("3 jam", Fault::Of(3, OfServo::Jam(true))),
            (" 3  free ", Fault::Of(3, OfServo::Jam(false))),
            ("1 load -0.5", Fault::Of(1, OfServo::Load(-0.5))),
            ("2 vanish", Fault::Of(2, OfServo::Absent(true))),
            ("2 return", Fault::Of(2, OfServo::Absent(false))),
            ("6 corrupt 10", Fault::Of(6, OfServo::Corrupt(10))),
            ("4 id 5", Fault::Of(4, OfServo::Id(5))),
            ("supply 5.5", Fault::Supply(5.5)),
        ];
        for (line, fault) in lines {
            assert_eq!(line.parse(), Ok(fault));
        }
        for line in [
            "",
            "jam",
            "0 jam",
            "1 jam 2",
            "1 load inf",
            "1 id 253",
            "supply -1",
            "supply",
            "x vanish",
        ] {
            assert!(line.parse::<Fault>().is_err(), "{line}");
        }
    }
}
