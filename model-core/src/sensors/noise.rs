//! Seeded Gaussian noise, the same on every target.
//!
//! PCG-32 (O'Neill, HMC-CS-2014-0905) generates the bits, the Box-Muller transform (Ann. Math.
//! Statist. 29, 1958, p. 610) computed with `libm` makes them Gaussian.

use core::f64::consts::TAU;

use rand_pcg::{Pcg32, rand_core::Rng};

/// A stream of Gaussian numbers.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Noise {
    bits: Pcg32,
    /// Second number of the last Box-Muller pair.
    spare: Option<f64>,
}

impl Noise {
    /// Stream `stream` of the seed `seed`. Streams of one seed are independent: each sensor uses
    /// its own, so that the draws of one sensor do not affect another.
    ///
    /// ```
    /// use model_core::sensors::noise::Noise;
    ///
    /// let (mut a, mut b) = (Noise::new(7, 0), Noise::new(7, 0));
    /// assert_eq!(a.gaussian(1.0), b.gaussian(1.0));
    /// assert_eq!(a.gaussian(0.0), 0.0);
    /// ```
    pub fn new(seed: u64, stream: u64) -> Self {
        Self {
            bits: Pcg32::new(seed, stream),
            spare: None,
        }
    }

    /// A Gaussian number of mean 0 and this standard deviation. With a deviation of 0 no number is
    /// drawn.
    pub fn gaussian(&mut self, deviation: f64) -> f64 {
        if deviation == 0.0 {
            return 0.0;
        }
        let number = match self.spare.take() {
            Some(number) => number,
            None => {
                // From 2^-32 to 1: the logarithm is finite and the radius at most 6.7.
                let radius = libm::sqrt(-2.0 * libm::log(self.uniform()));
                let angle = TAU * self.uniform();
                self.spare = Some(radius * libm::sin(angle));
                radius * libm::cos(angle)
            }
        };
        deviation * number
    }

    /// Uniform in (0, 1].
    fn uniform(&mut self) -> f64 {
        (f64::from(self.bits.next_u32()) + 1.0) / 4_294_967_296.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moments_are_those_of_a_gaussian() {
        let mut noise = Noise::new(1, 2);
        let count = 100_000;
        let (mut sum, mut squares, mut beyond) = (0.0, 0.0, 0);
        for _ in 0..count {
            let x = noise.gaussian(2.0);
            sum += x;
            squares += x * x;
            beyond += i32::from(x.abs() > 4.0);
        }
        let n = f64::from(count);
        // Three standard errors each: 2/sqrt(n); 4 sqrt(2/n); sqrt(0.0455 0.9545/n).
        assert!((sum / n).abs() < 0.019);
        assert!((squares / n - 4.0).abs() < 0.054);
        assert!((f64::from(beyond) / n - 0.0455).abs() < 0.002);
    }

    #[test]
    fn a_seed_gives_the_same_numbers_on_every_target() {
        let mut noise = Noise::new(42, 54);
        let numbers: [f64; 3] = core::array::from_fn(|_| noise.gaussian(1.0));
        // PCG-32's reference output for (42, 54) starts a15c02b7 7b47f409 ba1d3330 83d2f293.
        let uniform = |bits: u32| (f64::from(bits) + 1.0) / 4_294_967_296.0;
        let radius = libm::sqrt(-2.0 * libm::log(uniform(0xa15c_02b7)));
        let angle = TAU * uniform(0x7b47_f409);
        assert_eq!(numbers[0], radius * libm::cos(angle));
        assert_eq!(numbers[1], radius * libm::sin(angle));
        let radius = libm::sqrt(-2.0 * libm::log(uniform(0xba1d_3330)));
        assert_eq!(numbers[2], radius * libm::cos(TAU * uniform(0x83d2_f293)));
    }

    #[test]
    fn streams_of_one_seed_differ() {
        assert_ne!(
            Noise::new(1, 0).gaussian(1.0),
            Noise::new(1, 1).gaussian(1.0)
        );
    }
}
