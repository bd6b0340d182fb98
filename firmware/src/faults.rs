//! Faults: numbers, latching and acknowledgement, conditions and reactions.

mod latched;
mod remedy;
mod set;
mod table;
#[cfg(test)]
mod tests;

pub use latched::LatchedFaults;
pub use set::FaultSet;
pub use table::{
    ALWAYS, FaultDescription, HOLDABLE, OF_COMMANDS, PERMANENT, Reaction, TABLE, Watched,
};

/// A fault. The numbers never change: they are transmitted on the bus and stored in logs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u16)]
pub enum Fault {
    /// The encoder's words are missing or invalid.
    EncoderInvalid = 1,
    /// The encoder has lost its magnet.
    MagnetLost = 2,
    /// The magnet's field has been outside its recommended range for too long.
    MagnetWeak = 3,
    /// The motor turns, or must turn as it is driven, while the encoder's angle does not change.
    EncoderStuck = 4,
    /// The encoder's angle jumps further than the shaft can turn.
    EncoderJump = 5,
    /// The motor current is above its limit.
    OverCurrent = 6,
    /// The motor current was above its continuous value for too long.
    Overload = 7,
    /// The bridge's own over-current trip has switched it off.
    BridgeTripped = 8,
    /// The shaft does not turn at a high motor current.
    Stall = 9,
    /// The shaft does not follow the command.
    FollowingError = 10,
    /// The supply voltage is too low to drive.
    UnderVoltage = 11,
    /// The supply voltage is too high.
    OverVoltage = 12,
    /// The board is too hot.
    OverTemperature = 13,
    /// Current, legs, supply or temperature cannot be measured.
    MeasurementLost = 14,
    /// No command arrived in time.
    CommandTimeout = 15,
    /// Control periods were missed.
    LoopOverrun = 16,
    /// The stored parameters could not be read; the defaults are in use.
    ParametersCorrupt = 17,
    /// The CAN controller has left the bus.
    BusOff = 18,
    /// The watchdog has reset the board.
    WatchdogReset = 19,
    /// The measured motor current is far below what duty, supply and back-EMF make.
    CurrentImplausible = 20,
    /// The encoder turns against the back-EMF.
    MotorPolarity = 21,
    /// The two copies of the control loop differ, or a message to them is corrupt.
    DataCorrupt = 22,
    /// The program's flash differs from the program that was built.
    ProgramCorrupt = 23,
    /// The encoder's travel differs from that of the motor.
    EncoderImplausible = 24,
}

impl Fault {
    /// All faults in the order of their numbers.
    pub const ALL: [Self; 24] = [
        Self::EncoderInvalid,
        Self::MagnetLost,
        Self::MagnetWeak,
        Self::EncoderStuck,
        Self::EncoderJump,
        Self::OverCurrent,
        Self::Overload,
        Self::BridgeTripped,
        Self::Stall,
        Self::FollowingError,
        Self::UnderVoltage,
        Self::OverVoltage,
        Self::OverTemperature,
        Self::MeasurementLost,
        Self::CommandTimeout,
        Self::LoopOverrun,
        Self::ParametersCorrupt,
        Self::BusOff,
        Self::WatchdogReset,
        Self::CurrentImplausible,
        Self::MotorPolarity,
        Self::DataCorrupt,
        Self::ProgramCorrupt,
        Self::EncoderImplausible,
    ];

    /// Its number.
    ///
    /// ```
    /// assert_eq!(firmware::faults::Fault::BusOff.number(), 18);
    /// ```
    pub const fn number(self) -> u16 {
        self as u16
    }

    /// The fault of a number.
    ///
    /// ```
    /// use firmware::faults::Fault;
    /// assert_eq!(Fault::of_number(9), Some(Fault::Stall));
    /// assert_eq!(Fault::of_number(0), None);
    /// ```
    pub fn of_number(number: u16) -> Option<Self> {
        let index = usize::from(number).checked_sub(1)?;
        Self::ALL.get(index).copied()
    }
}
