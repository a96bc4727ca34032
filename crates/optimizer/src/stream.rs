//! Random numbers that depend only on the seed, the vehicle and the tick.

use rand::SeedableRng;

/// A stream of random numbers: ChaCha with 8 rounds, the same bits on every platform.
pub type Stream = rand::rngs::ChaCha8Rng;

/// The stream of one vehicle at one tick. The generator is counter-based and all three numbers are its key, so streams
/// are independent of each other and of the order in which threads draw from them.
pub fn stream(seed: u64, vehicle: u64, tick: u64) -> Stream {
    let mut key = [0; 32];
    for (part, number) in key.chunks_exact_mut(8).zip([seed, vehicle, tick]) {
        part.copy_from_slice(&number.to_le_bytes());
    }
    Stream::from_seed(key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;
    use std::collections::HashSet;

    #[test]
    fn each_of_the_three_numbers_changes_the_stream() {
        let keys = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (0, 1, 1), (1, 0, 1), (1, 1, 1)];
        let firsts: HashSet<u64> = keys.iter().map(|&(s, v, t)| stream(s, v, t).next_u64()).collect();
        assert_eq!(firsts.len(), keys.len());
    }

    #[test]
    fn the_same_numbers_give_the_same_stream() {
        let (mut a, mut b) = (stream(3, 1, 4), stream(3, 1, 4));
        assert!((0..1000).all(|_| a.next_u64() == b.next_u64()));
    }
}
