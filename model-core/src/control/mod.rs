//! The control step of the board: encoder word in, compare value out, every 4 ms.
//!
//! ```text
//!   AS5045 word -> angle -------------------------------+
//!                    |                                  |
//!                    +-> rate estimate ----------+      |
//!                                                v      v
//!   command -> position limits -> (-) -> P -> (-) -> PI -> duty limits -> compare value
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
//! callers are the firmware's application and every simulation. The parts are private: each leans
//! on bounds that [`cascade::Coefficients::try_new`] has checked.

mod arithmetic;
pub mod cascade;
pub mod compare;
pub mod encoder_word;
pub mod parameters;
mod position_loop;
mod rate_estimate;
mod rate_loop;
mod scaled;
mod shaft_angle;
pub mod units;

#[cfg(test)]
mod tests;
