//! Random numbers of one vehicle, each of which depends on what it is for and when, and on nothing else.

use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};
use std::f64::consts::TAU;

/// What a random number is for. The number is part of the key: a new one goes to the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    Gusts,
    Gps,
    Barometer,
    Pitot,
    Accelerometer,
    Gyroscope,
    Compass,
    Radio,
}

/// The random numbers of one vehicle. The generator is counter-based: who asks, how often and in which order changes
/// nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    seed: u64,
    vehicle: u64,
}

impl Noise {
    pub fn new(seed: u64, vehicle: u64) -> Self {
        Self { seed, vehicle }
    }

    /// Independent numbers of the standard normal distribution, of one tick.
    pub fn normals<const N: usize>(&self, source: Source, tick: u64) -> [f64; N] {
        let mut stream = self.stream(source, tick);
        // Box and Muller: two uniform numbers are an angle and a radius.
        std::array::from_fn(|_| {
            let (angle, radius) = (TAU * uniform(&mut stream), (-2.0 * libm::log(uniform(&mut stream))).sqrt());
            radius * libm::cos(angle)
        })
    }

    /// Whether something of a probability from 0 to 1 happens.
    pub fn happens(&self, source: Source, tick: u64, probability: f64) -> bool {
        uniform(&mut self.stream(source, tick)) <= probability
    }

    fn stream(&self, source: Source, tick: u64) -> ChaCha8Rng {
        let mut key = [0; 32];
        for (part, number) in key.chunks_exact_mut(8).zip([self.seed, self.vehicle, source as u64, tick]) {
            part.copy_from_slice(&number.to_le_bytes());
        }
        ChaCha8Rng::from_seed(key)
    }
}

/// Uniform in (0, 1].
fn uniform(stream: &mut ChaCha8Rng) -> f64 {
    const STEPS: f64 = (1_u64 << 53) as f64;
    ((stream.next_u64() >> 11) + 1) as f64 / STEPS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_depend_on_every_part_of_the_key_and_on_nothing_else() {
        let draw = |seed, vehicle, source, tick| Noise::new(seed, vehicle).normals::<1>(source, tick)[0];
        let first = draw(1, 2, Source::Gps, 3);
        assert_eq!(draw(1, 2, Source::Gps, 3), first);
        for other in [
            draw(2, 2, Source::Gps, 3),
            draw(1, 3, Source::Gps, 3),
            draw(1, 2, Source::Gusts, 3),
            draw(1, 2, Source::Gps, 4),
        ] {
            assert_ne!(other, first);
        }
    }

    #[test]
    fn they_are_normal() {
        let noise = Noise::new(7, 1);
        let all: Vec<f64> = (0..20_000).flat_map(|tick| noise.normals::<5>(Source::Gusts, tick)).collect();
        let mean = |value: &dyn Fn(f64) -> f64| all.iter().map(|&x| value(x)).sum::<f64>() / all.len() as f64;
        assert!(mean(&|x| x).abs() < 0.01);
        assert!((mean(&|x| x * x) - 1.0).abs() < 0.02);
        assert!((mean(&|x| f64::from(x.abs() < 1.0)) - 0.6827).abs() < 0.01);
    }

    #[test]
    fn chances_come_true_as_often_as_they_say() {
        let noise = Noise::new(7, 1);
        let count = |probability| (0..10_000).filter(|&t| noise.happens(Source::Radio, t, probability)).count();
        assert_eq!((count(0.0), count(1.0)), (0, 10_000));
        assert!((2_850..3_150).contains(&count(0.3)));
    }
}
