//! What to do about each fault.

use super::Fault;

impl Fault {
    /// What to do about it before it is reset. The sentences are for documents and tools; the
    /// board's program contains none of them.
    ///
    /// ```
    /// assert!(firmware::faults::Fault::Stall.remedy().starts_with("Free the shaft"));
    /// ```
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::EncoderInvalid => "Check the cable and the supply of the encoder.",
            Self::MagnetLost => {
                "Check that the magnet is there, centred and at the right distance."
            }
            Self::MagnetWeak => "Bring the magnet closer to the encoder, or centre it.",
            Self::EncoderStuck => {
                "Turn the shaft by hand: if the angle does not change, check the magnet's mount and the \
                 encoder. If it does, check whether the motor is connected."
            }
            Self::EncoderJump => {
                "Check the encoder's cable for interference, and the magnet's mount."
            }
            Self::EncoderImplausible => {
                "Check that the magnet is fixed to the shaft and the gears are whole, and that object 2011h has the \
                 torque constant and the gear ratio of the motor."
            }
            Self::OverCurrent => {
                "Look for a short circuit of the motor or its cable. If it comes with reversals, lower \
                 the acceleration or the duty limit."
            }
            Self::Overload => {
                "Let the motor cool, and reduce the load or the temperature around it. Object 2011h has its thermal model."
            }
            Self::BridgeTripped => {
                "Look for a short circuit of the motor, its cable or the bridge before you enable again."
            }
            Self::Stall => "Free the shaft, or move the target away from what blocks it.",
            Self::FollowingError => {
                "Look for what slows the shaft. If nothing does, lower the profile velocity or check the \
                 gains and the position limits."
            }
            Self::UnderVoltage => {
                "Check the supply and its cables; a supply that sags is too weak."
            }
            Self::OverVoltage => {
                "Lower the supply. If it comes with braking, the supply takes no current back."
            }
            Self::OverTemperature => {
                "Let the board cool, and reduce the load or improve the cooling."
            }
            Self::MeasurementLost => {
                "Repair the board: current, supply or temperature is not measured."
            }
            Self::CommandTimeout => {
                "Find out why the master fell silent: this program, its page, the cable or the bus load."
            }
            Self::LoopOverrun => {
                "Report it: the program has missed control periods. Lower the load of the bus meanwhile."
            }
            Self::ParametersCorrupt => {
                "The defaults are in use. Check the parameters, correct them from a file, and save them."
            }
            Self::BusOff => "Check termination, bit rate and cables of the bus.",
            Self::WatchdogReset => {
                "Report it: the program has hung. The log of the board says more."
            }
            Self::CurrentImplausible => {
                "Check that the motor is connected; if it is, the measurement of the current is faulty."
            }
            Self::MotorPolarity => {
                "Exchange the two wires of the motor, or correct the encoder direction."
            }
            Self::DataCorrupt => "Reset it once. If it comes again, replace the board.",
            Self::ProgramCorrupt => "Flash the program again; a reset does not help.",
        }
    }
}
