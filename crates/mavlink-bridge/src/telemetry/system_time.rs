//! Time since boot, and SYSTEM_TIME.

use crate::dialect::{Message, SYSTEM_TIME_DATA};
use std::time::Duration;

/// A time since boot as `time_boot_ms`: whole milliseconds, the rest cut off. It wraps after 2^32 ms (49.7 days).
pub fn boot_ms(time_boot: Duration) -> u32 {
    time_boot.as_millis() as u32
}

/// SYSTEM_TIME (<https://mavlink.io/en/messages/common.html#SYSTEM_TIME>).
pub fn system_time(time_boot: Duration, unix_time: Duration) -> Message {
    Message::SYSTEM_TIME(SYSTEM_TIME_DATA {
        time_unix_usec: u64::try_from(unix_time.as_micros()).unwrap_or(u64::MAX),
        time_boot_ms: boot_ms(time_boot),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_wraps_after_fifty_days() {
        assert_eq!(boot_ms(Duration::from_micros(500_999)), 500);
        assert_eq!(boot_ms(Duration::from_millis((1 << 32) + 7)), 7);
    }
}
