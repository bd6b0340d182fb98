//! The signals that can be recorded.

use crate::{
    interface::{Bridge, Outputs},
    timing::thousandths,
};

macro_rules! signals {
    ($($(#[doc = $doc:literal])+ $Signal:ident = $number:literal, $column:literal, $value:expr;)+) => {
        /// A signal that can be recorded, as an `i32`. The numbers are part of the bus interface
        /// and never change.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u8)]
        pub enum Signal {
            $($(#[doc = $doc])+ $Signal = $number,)+
        }

        impl Signal {
            /// All signals.
            pub const ALL: &'static [Self] = &[$(Self::$Signal),+];

            /// The signal of a number.
            ///
            /// ```
            /// use firmware::capture::Signal;
            /// assert_eq!(Signal::of_number(0), Some(Signal::Angle));
            /// assert_eq!(Signal::of_number(200), None);
            /// ```
            pub const fn of_number(number: u8) -> Option<Self> {
                match number {
                    $($number => Some(Self::$Signal),)+
                    _ => None,
                }
            }

            /// Name of its column in a file, with the unit.
            ///
            /// ```
            /// assert_eq!(firmware::capture::Signal::Angle.column(), "angle_mdeg");
            /// ```
            pub const fn column(self) -> &'static str {
                match self {
                    $(Self::$Signal => $column,)+
                }
            }

            /// Its value in a control period.
            pub fn of(self, outputs: &Outputs) -> i32 {
                match self {
                    $(Self::$Signal => {
                        let value: fn(&Outputs) -> i32 = $value;
                        value(outputs)
                    })+
                }
            }
        }
    };
}

signals! {
    /// The measured angle, mdeg.
    Angle = 0, "angle_mdeg", |o| thousandths(o.telemetry.angle);
    /// The estimated rate, mdeg/s.
    Rate = 1, "rate_mdeg_s", |o| thousandths(o.telemetry.rate);
    /// Motor current, mA.
    Current = 2, "current_ma", |o| o.telemetry.current_ma;
    /// Back-EMF, mV.
    BackEmf = 3, "back_emf_mv", |o| o.telemetry.back_emf_mv;
    /// The duty, 0.001 %.
    Duty = 4, "duty_mpct", |o| thousandths(o.telemetry.duty);
    /// The commanded angle, mdeg.
    Command = 5, "command_mdeg", |o| thousandths(o.telemetry.command);
    /// The commanded rate, mdeg/s.
    RateCommand = 6, "rate_command_mdeg_s", |o| thousandths(o.telemetry.rate_command);
    /// Supply voltage, mV.
    Supply = 7, "supply_mv", |o| o.telemetry.supply_mv;
    /// Temperature, thousandths of a degree Celsius.
    Temperature = 8, "temperature_mdeg_c", |o| o.telemetry.temperature_mdeg_c;
    /// The compare value of the bridge, 0 while it is off.
    Compare = 9, "compare_counts", |o| match o.bridge {
        Bridge::Driven(compare) => compare.get(),
        Bridge::Coast | Bridge::Brake => 0,
    };
    /// The operating state.
    State = 10, "state", |o| o.state as i32;
    /// The number of the first fault that is latched, 0 for none.
    Fault = 11, "fault", |o| o.fault.map_or(0, |fault| i32::from(fault.number()));
    /// The number of the control period, its low 31 bits.
    Tick = 12, "tick", |o| (o.telemetry.tick & 0x7fff_ffff) as i32;
    /// The servo pulse, us.
    ServoPulse = 13, "servo_pulse_us", |o| i32::from(o.telemetry.servo_pulse_us);
}
