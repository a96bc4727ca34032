//! Which seeds are flown, as they are written on the command line.

use std::str::FromStr;

/// More flights of one contender tell nothing more.
const SEEDS_MAX: u64 = 100_000;

/// Seeds in the order in which they were asked for, each once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seeds(Vec<u64>);

impl Seeds {
    /// The seeds; at least one.
    pub fn as_slice(&self) -> &[u64] {
        &self.0
    }
}

impl FromStr for Seeds {
    type Err = String;

    /// `100` is 1 to 100, `101..200` both ends and what lies between, `7..7` a single one, `3,5,101..110` all of these.
    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = || {
            format!(
                "must be how many (100), a range with both ends (101..200) or a list (3,5,8..9), at most {SEEDS_MAX}"
            )
        };
        let number = |text: &str| text.trim().parse::<u64>().map_err(|_| wanted());
        let ranges = match text.parse::<u64>() {
            Ok(count) => vec![(1, count)],
            Err(_) => text
                .split(',')
                .map(|part| match part.split_once("..") {
                    Some((first, last)) => Ok((number(first)?, number(last)?)),
                    None => number(part).map(|seed| (seed, seed)),
                })
                .collect::<Result<_, String>>()?,
        };
        let mut seeds = Vec::new();
        for (first, last) in ranges {
            if first > last || last - first >= SEEDS_MAX || seeds.len() as u64 + (last - first) >= SEEDS_MAX {
                return Err(wanted());
            }
            seeds.extend(first..=last);
        }
        let mut sorted = seeds.clone();
        sorted.sort_unstable();
        match sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(format!("must name every seed once: {} is there twice", pair[0])),
            None => Ok(Self(seeds)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Vec<u64> {
        text.parse::<Seeds>().unwrap_or_else(|error| panic!("{text}: {error}")).as_slice().to_vec()
    }

    #[test]
    fn a_number_a_range_and_a_list() {
        assert_eq!(of("3"), [1, 2, 3]);
        assert_eq!(of("101..103"), [101, 102, 103]);
        assert_eq!(of("7..7"), [7]);
        assert_eq!(of("9, 2,4..5"), [9, 2, 4, 5]);
        assert_eq!(of("18446744073709551615..18446744073709551615"), [u64::MAX]);
    }

    #[test]
    fn what_is_no_list_of_seeds_is_refused_in_words() {
        for text in ["", "0", "-1", "1.5", "5..1", "1..", "..3", "a", "1,", "0..18446744073709551615", "100001"] {
            let refusal = text.parse::<Seeds>().unwrap_err();
            assert!(refusal.starts_with("must be how many (100), a range"), "{text}: {refusal}");
        }
        assert_eq!("1..5,3".parse::<Seeds>().unwrap_err(), "must name every seed once: 3 is there twice");
    }
}
