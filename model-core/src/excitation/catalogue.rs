//! The standard inputs by name, with their parameters.
//!
//! A command line selects an [`Input`] by name, lists its table, sets its parameters by name and
//! obtains the [`Excitation`].

use super::Excitation;
use super::chirp::{Chirp, ChirpParameters};
use super::multisine::{Multisine, MultisineParameters};
use super::multistep::{DoubletParameters, Multistep, PulseParameters, ThreeTwoOneOneParameters};
use super::prbs::{Prbs, PrbsParameters};
use super::ramp::{Ramp, RampParameters};
use super::steady_sine::{SineParameters, SteadySine};
use super::variable_step::{VariableStep, VariableStepParameters};
use crate::parameter::{Parameter, ParameterError, Parameters};
use crate::time::ticks;

macro_rules! catalogue {
    ($(
        $(#[doc = $summary:literal])+
        $Variant:ident($Parameters:ident) => $Excitation:ident, $constructor:expr,
        $name:literal $(or $alias:literal)?, rest $rest_s:literal;
    )+) => {
        /// A standard input with its parameters.
        ///
        /// ```
        /// use model_core::{excitation::catalogue::Input, time::ticks};
        /// let mut input = Input::named("chirp").unwrap();
        /// input.set("amplitude_deg", 2.0).unwrap();
        /// input.set("duration_s", 10.0).unwrap();
        /// assert_eq!(input.table()[0].name, "amplitude_deg");
        /// assert_eq!(input.duration_ticks().unwrap(), ticks(10.5));
        /// // 0.595 turn after one second.
        /// let command = input.excitation().unwrap().command(20_000).to_f64();
        /// assert!((command - 2.0 * (1.19 * core::f64::consts::PI).sin()).abs() < 1e-5);
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Input {
            $($(#[doc = $summary])+ $Variant($Parameters),)+
        }

        impl Input {
            /// The names of all inputs.
            pub const NAMES: &'static [&'static str] = &[$($name),+];

            /// The input with this name and default parameters. `varstep` and `3211` are aliases of
            /// `variable-step` and `3-2-1-1`.
            pub fn named(name: &str) -> Option<Self> {
                match name {
                    $($name $(| $alias)? => Some(Self::$Variant(Default::default())),)+
                    _ => None,
                }
            }

            /// Name.
            pub fn name(&self) -> &'static str {
                match self { $(Self::$Variant(_) => $name,)+ }
            }

            /// Alias, if any.
            pub fn alias(&self) -> Option<&'static str> {
                match self { $(Self::$Variant(_) => None$(.or(Some($alias)))?,)+ }
            }

            /// Description in one sentence.
            pub fn summary(&self) -> &'static str {
                match self {
                    $(Self::$Variant(_) => crate::parameter::trimmed(concat!($($summary),+)),)+
                }
            }

            /// Descriptions of its parameters.
            pub fn table(&self) -> &'static [Parameter] {
                match self { $(Self::$Variant(_) => $Parameters::TABLE,)+ }
            }

            /// The value of row `index` of the table; `None` beyond its end.
            pub fn get(&self, index: usize) -> Option<f64> {
                match self { $(Self::$Variant(parameters) => parameters.get(index),)+ }
            }

            /// Sets the parameter with this name or symbol.
            ///
            /// # Errors
            /// As for [`Parameters::set`].
            pub fn set(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
                match self { $(Self::$Variant(parameters) => parameters.set(name, value),)+ }
            }

            /// The input as a function of the tick.
            ///
            /// # Errors
            /// [`ParameterError::OutOfRange`] of the first parameter that is NaN or outside its
            /// range.
            pub fn excitation(&self) -> Result<Excitation<'static>, ParameterError> {
                match self {
                    $(Self::$Variant(parameters) =>
                        $constructor(parameters).map(Excitation::$Excitation),)+
                }
            }

            /// Duration of a run: the duration of the input plus a settling time of the actuator.
            ///
            /// # Errors
            /// As for [`Input::excitation`].
            pub fn duration_ticks(&self) -> Result<u64, ParameterError> {
                let rest_s = match self { $(Self::$Variant(_) => $rest_s,)+ };
                Ok(self.excitation()?.duration_ticks().saturating_add(ticks(rest_s)))
            }
        }
    };
}

catalogue! {
    /// One rectangular pulse.
    Pulse(PulseParameters) => Multistep, Multistep::try_pulse, "pulse", rest 2.0;
    /// Fourteen steps, small and large, up and down.
    VariableStep(VariableStepParameters) => VariableStep, VariableStep::try_new,
        "variable-step" or "varstep", rest 0.0;
    /// Straight lines up and down with holds.
    Ramp(RampParameters) => Ramp, Ramp::try_new, "ramp", rest 0.0;
    /// A sine with linearly increasing frequency.
    Chirp(ChirpParameters) => Chirp, Chirp::try_linear, "chirp", rest 0.5;
    /// A sine with exponentially increasing frequency.
    LogChirp(ChirpParameters) => Chirp, Chirp::try_logarithmic, "log-chirp", rest 0.5;
    /// A sine of one frequency.
    Sine(SineParameters) => Sine, SteadySine::try_new, "sine", rest 4.0;
    /// Three units up, two down, one up, one down.
    ThreeTwoOneOne(ThreeTwoOneOneParameters) => Multistep, Multistep::try_3211,
        "3-2-1-1" or "3211", rest 1.9;
    /// One unit up, one unit down.
    Doublet(DoubletParameters) => Multistep, Multistep::try_doublet, "doublet", rest 1.9;
    /// A pseudo-random binary sequence.
    Prbs(PrbsParameters) => Prbs, Prbs::try_new, "prbs", rest 0.0;
    /// A sum of cosines at the odd multiples of one frequency.
    Multisine(MultisineParameters) => Multisine, Multisine::try_new, "multisine", rest 4.0;
}
