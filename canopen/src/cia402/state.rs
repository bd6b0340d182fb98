//! The states of a drive and the transitions 0 to 16 between them.

use super::{Command, Deceleration, QuickStop, StopOption, controlword};

/// State of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Initialising.
    NotReadyToSwitchOn,
    /// Parameters may be set; no voltage.
    SwitchOnDisabled,
    /// Voltage may be applied.
    ReadyToSwitchOn,
    /// Voltage is applied.
    SwitchedOn,
    /// The motor has power and obeys.
    OperationEnabled,
    /// Stopping, or stopped, by a quick stop.
    QuickStopActive,
    /// Stopping by a fault.
    FaultReactionActive,
    /// Without power by a fault.
    Fault,
}

/// Whether there is a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// There is none.
    None,
    /// There is one under which the drive can still stop in order, by 605Eh.
    Controlled,
    /// Power must go at once.
    Immediate,
}

/// What the state machine has to know of the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conditions {
    /// Initialisation is over.
    pub initialised: bool,
    /// The supply of the power stage is there.
    pub voltage: bool,
    /// A fault that is there now.
    pub fault: Fault,
    /// The demanded velocity is zero.
    pub standstill: bool,
}

/// Option codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// 605Ah.
    pub quick_stop: QuickStop,
    /// 605Bh.
    pub shutdown: StopOption,
    /// 605Ch.
    pub disable_operation: StopOption,
    /// 605Dh; [`StopOption::Disable`] is taken for a slow-down.
    pub halt: StopOption,
    /// 605Eh.
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
                stays: false,
            },
            shutdown: StopOption::Disable,
            disable_operation: slow,
            halt: slow,
            fault_reaction: quick,
        }
    }
}

/// What the drive does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Without power.
    Off,
    /// Follows its mode.
    Run,
    /// Slows down, and stands then.
    Stop(Deceleration),
}

/// The state and what it needs to go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateMachine {
    state: State,
    reset_bit: bool,
    /// Under a fault reaction: how to stop; `None` is not at all.
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
            state: State::NotReadyToSwitchOn,
            reset_bit: false,
            reaction: None,
        }
    }

    /// Where it is.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// At most one transition, and what the drive does in this period.
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn step(&mut self, word: u16, conditions: Conditions, options: &Options) -> Motion {
        let reset = word & controlword::FAULT_RESET != 0;
        let resets = reset && !self.reset_bit;
        self.reset_bit = reset;
        let faulty = matches!(self.state, State::FaultReactionActive | State::Fault);
        if conditions.fault != Fault::None && !faulty {
            return self.fail(conditions.fault, options);
        }
        match self.state {
            State::NotReadyToSwitchOn => {
                if conditions.initialised {
                    self.state = State::SwitchOnDisabled; // 1
                }
                Motion::Off
            }
            State::FaultReactionActive => self.react(conditions),
            State::Fault => {
                if resets && conditions.fault == Fault::None {
                    self.state = State::SwitchOnDisabled; // 15
                }
                Motion::Off
            }
            State::OperationEnabled => self.operate(word, conditions, options),
            State::QuickStopActive => self.quick_stop(word, conditions, options),
            _ => self.prepare(Command::from_controlword(word), conditions),
        }
    }

    /// Transition 13.
    fn fail(&mut self, fault: Fault, options: &Options) -> Motion {
        let powered = matches!(self.state, State::OperationEnabled | State::QuickStopActive);
        self.state = State::FaultReactionActive;
        self.reaction = match (options.fault_reaction, fault) {
            (StopOption::Stop(how), Fault::Controlled) if powered => Some(how),
            _ => None,
        };
        self.reaction.map_or(Motion::Off, Motion::Stop)
    }

    fn react(&mut self, conditions: Conditions) -> Motion {
        match self.reaction {
            Some(how) if !conditions.standstill && conditions.fault != Fault::Immediate => {
                Motion::Stop(how)
            }
            _ => {
                self.state = State::Fault; // 14
                Motion::Off
            }
        }
    }

    /// The states without power.
    fn prepare(&mut self, command: Command, conditions: Conditions) -> Motion {
        use Command::{DisableVoltage, EnableOperation, QuickStop, Shutdown, SwitchOn};
        use State::{OperationEnabled, ReadyToSwitchOn, SwitchOnDisabled, SwitchedOn};
        self.state = match (self.state, command) {
            (SwitchOnDisabled, Shutdown) => ReadyToSwitchOn, // 2
            (ReadyToSwitchOn, SwitchOn | EnableOperation) if conditions.voltage => SwitchedOn, // 3
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

    fn operate(&mut self, word: u16, conditions: Conditions, options: &Options) -> Motion {
        let (option, next) = match Command::from_controlword(word) {
            Command::EnableOperation => {
                return match (word & controlword::HALT != 0, options.halt) {
                    (false, _) => Motion::Run,
                    (true, StopOption::Stop(how)) => Motion::Stop(how),
                    (true, StopOption::Disable) => Motion::Stop(Deceleration::SlowDown),
                };
            }
            Command::QuickStop => {
                self.state = State::QuickStopActive; // 11
                return self.quick_stop(word, conditions, options);
            }
            Command::SwitchOn => (options.disable_operation, State::SwitchedOn), // 5
            Command::Shutdown => (options.shutdown, State::ReadyToSwitchOn),     // 8
            Command::DisableVoltage => (StopOption::Disable, State::SwitchOnDisabled), // 9
        };
        match option {
            StopOption::Stop(how) if !conditions.standstill => Motion::Stop(how),
            _ => {
                self.state = next;
                Motion::Off
            }
        }
    }

    fn quick_stop(&mut self, word: u16, conditions: Conditions, options: &Options) -> Motion {
        let QuickStop { stop, stays } = options.quick_stop;
        let command = Command::from_controlword(word);
        if stays && command == Command::EnableOperation {
            self.state = State::OperationEnabled; // 16
            return Motion::Run;
        }
        match stop {
            StopOption::Stop(how)
                if command != Command::DisableVoltage && (stays || !conditions.standstill) =>
            {
                Motion::Stop(how)
            }
            _ => {
                self.state = State::SwitchOnDisabled; // 12
                Motion::Off
            }
        }
    }
}
