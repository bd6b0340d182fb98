//! Commands from the bus.

use crate::parameters::integers::integers;

integers! {
    /// Where commands come from, and how long one lasts.
    pub struct CommandSettings {
        /// Source after a reset: 0 the bus, 1 the servo pulse.
        command_source: 0, "choice", 0, 1, "the bus";
        /// Time after which a command is stale; 0 for never.
        command_timeout_ms: 100, "ms", 0, 60000, "five periods of a host at 50 Hz";
        /// Rate at which the command goes over to another source.
        approach_rate_deg_s: 60, "deg/s", 1, 2000, "a quarter of full rate";
    }
}
