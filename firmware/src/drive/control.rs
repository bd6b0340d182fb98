//! Application and axis, which the control step changes, and whether anything else may have.

use core::ops::{Deref, DerefMut};

use canopen::cia402::{Axis, Parameters};

use crate::application::Application;

/// The application, and the axis with its parameters.
#[derive(Debug)]
pub struct Control {
    pub(super) application: Application,
    pub(super) axis: Axis,
    pub(super) axis_parameters: Parameters,
}

/// A value, and the number of mutable accesses to it.
#[derive(Debug)]
pub struct Counted<T> {
    value: T,
    accesses: u32,
}

impl<T> Counted<T> {
    /// A value without accesses.
    pub(super) const fn new(value: T) -> Self {
        Self { value, accesses: 0 }
    }

    /// Number of mutable accesses, modulo 2^32. As long as it is the same, each byte of the value
    /// is the same.
    pub fn accesses(&self) -> u32 {
        self.accesses
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
        self.accesses = self.accesses.wrapping_add(1);
        &mut self.value
    }
}
