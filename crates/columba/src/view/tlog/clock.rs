//! The clock by which a log was written.

/// Where the time of a record is so far ahead of the one before, or behind, the clock was set meanwhile, microseconds:
/// a computer without a battery for its clock learns the time after it has started.
const AHEAD_MAX_US: u64 = 24 * 3600 * 1_000_000;
const BEHIND_MAX_US: u64 = 2_000_000;
/// So many jumps of a clock are told.
const JUMPS_MAX: usize = 20;

/// The clock by which a log was written, without its jumps.
#[derive(Clone, Default)]
pub struct Clock {
    /// Time of the last record as written, and as it is taken.
    last_us: Option<(u64, u64)>,
    /// The first jumps: when, and by how many seconds.
    pub jumps: Vec<(u64, f64)>,
}

impl Clock {
    /// Whether a record of this time may follow the last one.
    pub fn goes_on(&self, written_us: u64) -> bool {
        self.last_us.is_some_and(|(last_us, _)| {
            written_us < last_us.saturating_add(AHEAD_MAX_US) && written_us.saturating_add(BEHIND_MAX_US) > last_us
        })
    }

    /// The time of the last record, as it is taken.
    pub fn now_us(&self) -> Option<u64> {
        self.last_us.map(|(_, at_us)| at_us)
    }

    /// The time of the next record.
    pub fn at_us(&mut self, written_us: u64) -> u64 {
        let at_us = match self.last_us {
            None => written_us,
            Some((last_us, at_us)) if self.goes_on(written_us) => at_us
                .saturating_add(written_us.saturating_sub(last_us))
                .saturating_sub(last_us.saturating_sub(written_us)),
            Some((last_us, at_us)) => {
                if self.jumps.len() < JUMPS_MAX {
                    self.jumps.push((at_us, (written_us as f64 - last_us as f64) * 1e-6));
                }
                at_us
            }
        };
        self.last_us = Some((written_us, at_us));
        at_us
    }
}
