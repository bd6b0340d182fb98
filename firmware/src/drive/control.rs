//! What the control step works with, and whether anything else has changed it.

use core::ops::{Deref, DerefMut};

use canopen::cia402::{Axis, Parameters};

use crate::application::Application;

/// The application, and the axis with its parameters.
#[derive(Debug, Clone)]
pub struct Control {
    pub(super) application: Application,
    pub(super) axis: Axis,
    pub(super) axis_parameters: Parameters,
}

/// A value, and how often it may have been changed: each mutable access counts.
#[derive(Debug, Clone)]
pub struct Counted<T> {
    value: T,
    changes: u32,
}

impl<T> Counted<T> {
    /// A value that has not been changed.
    pub(super) const fn new(value: T) -> Self {
        Self { value, changes: 0 }
    }

    /// Number of mutable accesses, modulo 2^32. As long as it is the same, each byte of the value is
    /// the same.
    pub fn changes(&self) -> u32 {
        self.changes
    }
}

impl<T> Deref for Counted<T> {
    type Target = T;

    #[inline]
    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for Counted<T> {
    #[inline]
    fn deref_mut(&mut self) -> &mut T {
        self.changes = self.changes.wrapping_add(1);
        &mut self.value
    }
}
