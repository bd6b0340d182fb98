//! Queues between two tasks of different priorities, without locks, for memory in which a bit may
//! change.
//!
//! A queue is in a static, and its ends have no data: no task has a reference to it that could
//! change. Its positions show whether a bit of them has changed: the queue is then not intact
//! ([`Producer::is_intact`]), accepts nothing and yields nothing. No position leads to memory
//! outside the queue.
//!
//! ```
//! task_queues::channel!(
//!     /// Angles, deg.
//!     Angles: [f32; 4]
//! );
//! use task_queues::Channel;
//!
//! // SAFETY: the only call for this queue.
//! let (mut producer, mut consumer) = unsafe { Angles::split() };
//! assert_eq!(producer.enqueue(12.5), Ok(()));
//! assert_eq!(consumer.dequeue(), Some(12.5));
//! ```
#![no_std]

mod ends;
mod position;
mod queue;

pub use self::{
    ends::{Channel, Consumer, Producer},
    queue::{Queue, Slot},
};
