//! Drive state machine of CiA 402 with transitions 0 to 16. The numbers at the state changes are
//! those of the standard.

use super::{Command, Deceleration, QuickStop, StopOption, controlword};

/// State of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cia402State {
    /// Initialisation.
    NotReadyToSwitchOn,
    /// Parameters may be set; high voltage must not be applied.
    SwitchOnDisabled,
    /// High voltage may be applied.
    ReadyToSwitchOn,
    /// High voltage is applied; the drive function is disabled.
    SwitchedOn,
    /// The drive function is enabled.
    OperationEnabled,
    /// A quick stop is in progress or complete.
    QuickStopActive,
    /// The fault reaction is in progress.
    FaultReactionActive,
    /// The drive function is disabled by a fault.
    Fault,
}

/// Fault condition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// No fault.
    None,
    /// A fault with which the drive can still execute the fault reaction 605Eh.
    Controlled,
    /// A fault that requires the power stage to be switched off immediately.
    Immediate,
}

/// Conditions of the drive that the state machine evaluates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// Initialisation is complete.
    pub initialised: bool,
    /// The power stage has its supply voltage.
    pub voltage: bool,
    /// The fault that is present now.
    pub fault: Fault,
    /// The velocity demand is zero.
    pub standstill: bool,
}

/// Option codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Options {
    /// Quick stop 605Ah.
    pub quick_stop: QuickStop,
    /// Shutdown 605Bh.
    pub shutdown: StopOption,
    /// Disable operation 605Ch.
    pub disable_operation: StopOption,
    /// Halt 605Dh; [`StopOption::Disable`] acts like the slow down ramp.
    pub halt: StopOption,
    /// Fault reaction 605Eh.
    pub fault_reaction: StopOption,
}

impl Default for Options {
    /// The defaults of CiA 402.
    fn default() -> Self {
        let quick = StopOption::Stop(Deceleration::QuickStop);
        let slow = StopOption::Stop(Deceleration::SlowDown);
        Self {
            quick_stop: QuickStop {
                stop: quick,
                remains_active: false,
            },
            shutdown: StopOption::Disable,
            disable_operation: slow,
            halt: slow,
            fault_reaction: quick,
        }
    }
}

/// Action of the drive in one control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Power stage off.
    Off,
    /// Executes the mode of operation.
    Run,
    /// Decelerates to standstill.
    Stop(Deceleration),
}

/// The state machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateMachine {
    state: Cia402State,
    /// The command of the last controlword that had one.
    command: Command,
    reset_bit: bool,
    /// Deceleration of the fault reaction; `None` switches off immediately.
    reaction: Option<Deceleration>,
}

impl Default for StateMachine {
    fn default() -> Self {
        Self::new()
    }
}

impl StateMachine {
    /// Transition 0: power-on.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: Cia402State::NotReadyToSwitchOn,
            command: Command::DisableVoltage,
            reset_bit: false,
            reaction: None,
        }
    }

    /// Present state.
    #[must_use]
    pub const fn state(&self) -> Cia402State {
        self.state
    }

    /// Performs at most one transition, or 3 and 4 together; returns the action in this period.
    pub fn step(&mut self, word: u16, conditions: Conditions, options: &Options) -> Motion {
        let reset = word & controlword::FAULT_RESET != 0;
        let resets = reset && !self.reset_bit;
        self.reset_bit = reset;
        // The commands have bit 7 clear; those that remove power act in any case.
        let command = Command::from_controlword(word);
        if !reset || matches!(command, Command::DisableVoltage | Command::QuickStop) {
            self.command = command;
        }
        let faulty = matches!(
            self.state,
            Cia402State::FaultReactionActive | Cia402State::Fault
        );
        if conditions.fault != Fault::None && !faulty {
            return self.start_fault_reaction(conditions.fault, options);
        }
        match self.state {
            Cia402State::NotReadyToSwitchOn => {
                if conditions.initialised {
                    self.state = Cia402State::SwitchOnDisabled; // 1
                }
                Motion::Off
            }
            Cia402State::FaultReactionActive => self.fault_reaction(conditions),
            Cia402State::Fault => {
                if resets && conditions.fault == Fault::None {
                    self.state = Cia402State::SwitchOnDisabled; // 15
                    // A command given in the fault does not act behind its reset.
                    self.command = Command::DisableVoltage;
                }
                Motion::Off
            }
            Cia402State::OperationEnabled => self.operation_enabled(word, conditions, options),
            Cia402State::QuickStopActive => self.quick_stop(conditions, options),
            _ => self.unpowered(self.command, conditions),
        }
    }

    /// Transition 13.
    fn start_fault_reaction(&mut self, fault: Fault, options: &Options) -> Motion {
        let powered = matches!(
            self.state,
            Cia402State::OperationEnabled | Cia402State::QuickStopActive
        );
        self.state = Cia402State::FaultReactionActive;
        self.reaction = match (options.fault_reaction, fault) {
            (StopOption::Stop(how), Fault::Controlled) if powered => Some(how),
            _ => None,
        };
        self.reaction.map_or(Motion::Off, Motion::Stop)
    }

    fn fault_reaction(&mut self, conditions: Conditions) -> Motion {
        match self.reaction {
            Some(how) if !conditions.standstill && conditions.fault != Fault::Immediate => {
                Motion::Stop(how)
            }
            _ => {
                self.state = Cia402State::Fault; // 14
                Motion::Off
            }
        }
    }

    /// The states with the power stage off.
    fn unpowered(&mut self, command: Command, conditions: Conditions) -> Motion {
        use Cia402State::{OperationEnabled, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn};
        use Command::{DisableVoltage, EnableOperation, QuickStop, Shutdown, SwitchOn};
        self.state = match (self.state, command) {
            (SwitchOnDisabled, Shutdown) => ReadyToSwitchOn, // 2
            (ReadyToSwitchOn, SwitchOn) if conditions.voltage => SwitchedOn, // 3
            (ReadyToSwitchOn, EnableOperation) if conditions.voltage => OperationEnabled, // 3, 4
            (SwitchedOn, EnableOperation) => OperationEnabled, // 4
            (SwitchedOn, Shutdown) => ReadyToSwitchOn,       // 6
            (ReadyToSwitchOn | SwitchedOn, QuickStop | DisableVoltage) => SwitchOnDisabled, // 7, 10
            (same, _) => same,
        };
        if self.state == OperationEnabled {
            Motion::Run
        } else {
            Motion::Off
        }
    }

    fn operation_enabled(
        &mut self,
        word: u16,
        conditions: Conditions,
        options: &Options,
    ) -> Motion {
        let (option, next) = match self.command {
            Command::EnableOperation => {
                return match (word & controlword::HALT != 0, options.halt) {
                    (false, _) => Motion::Run,
                    (true, StopOption::Stop(how)) => Motion::Stop(how),
                    (true, StopOption::Disable) => Motion::Stop(Deceleration::SlowDown),
                };
            }
            Command::QuickStop => {
                self.state = Cia402State::QuickStopActive; // 11
                return self.quick_stop(conditions, options);
            }
            Command::SwitchOn => (options.disable_operation, Cia402State::SwitchedOn), // 5
            Command::Shutdown => (options.shutdown, Cia402State::ReadyToSwitchOn),     // 8
            Command::DisableVoltage => (StopOption::Disable, Cia402State::SwitchOnDisabled), // 9
        };
        match option {
            StopOption::Stop(how) if !conditions.standstill => Motion::Stop(how),
            _ => {
                self.state = next;
                Motion::Off
            }
        }
    }

    fn quick_stop(&mut self, conditions: Conditions, options: &Options) -> Motion {
        let QuickStop {
            stop,
            remains_active,
        } = options.quick_stop;
        if remains_active && self.command == Command::EnableOperation {
            self.state = Cia402State::OperationEnabled; // 16
            return Motion::Run;
        }
        match stop {
            StopOption::Stop(how)
                if self.command != Command::DisableVoltage
                    && (remains_active || !conditions.standstill) =>
            {
                Motion::Stop(how)
            }
            _ => {
                self.state = Cia402State::SwitchOnDisabled; // 12
                Motion::Off
            }
        }
    }
}
