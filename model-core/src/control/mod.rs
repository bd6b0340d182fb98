//! The control step of the board: encoder count in, duty out, once in each control period.
//!
//! ```text
//!   encoder count -> angle -----------------------------+
//!                    |                                  |
//!                    +-> rate estimate ----------+      |
//!                                                v      v
//!   command -> position limits -> (-) -> P -> (-) -> PI -> duty limits -> duty
//!                                                 ^               |
//!                                                 +- anti-windup -+
//! ```
//!
//! Equations, units and order are those of the paper (section II.B) as `docs/model.md` reads them:
//!
//! ```text
//!   r = clamp(P (c - angle), -down, +up)             deg/s
//!   e = r - rate                                     deg/s
//!   v = Kp e + x + Kff r                             %
//!   u = limit(v)                                     %
//!   x = x + T (Ki e + Kaw (u - v))                   %
//! ```
//!
//! Everything is fixed point; no step allocates, divides by a variable that may be zero, or
//! panics, whatever the encoder and the bus deliver. [`cascade`] puts the parts together; its
//! callers are the firmware's application and every simulation. The parts are private: each
//! relies on bounds that [`cascade::Coefficients::try_new`] has checked.

mod arithmetic;
pub mod cascade;
pub mod encoder_correction;
pub mod encoder_word;
pub mod lanes;
pub mod parameters;
mod position_loop;
pub mod pwm_timer;
mod rate_estimate;
mod rate_loop;
mod scaled;
pub mod shaft_tracker;
pub mod units;

#[cfg(test)]
mod state_tests;
#[cfg(test)]
mod tests;
