//! Counts in words, in the singular and the plural.

/// `1 obstacle`, `7 obstacles`: a count with its noun, which takes an s.
pub fn counted(count: usize, noun: &str) -> String {
    if count == 1 { format!("1 {noun}") } else { format!("{count} {noun}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_is_singular() {
        assert_eq!([0, 1, 2].map(|count| counted(count, "UAV")), ["0 UAVs", "1 UAV", "2 UAVs"]);
    }
}
