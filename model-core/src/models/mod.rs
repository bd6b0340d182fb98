//! The paper's three actuator models, in `f64`.

crate::parameters! {
    /// What the test set-up does to a command on its way to the actuator.
    pub struct SetupParameters {
        /// Transport delay of the command, outside every loop.
        delay_s ["delay"]: 0.0175, "s", 0.0, 1.0, "paper, section III: 0.0175 seconds";
        /// Period at which the host samples the command; 0 passes it on at every tick.
        host_period_s [""]: 0.0, "s", 0.0, 1.0, "the paper's host runs at 0.02 s";
    }
}
