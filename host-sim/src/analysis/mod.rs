//! Frequency responses, margins of the sampled loop and figures of merit of a step.
