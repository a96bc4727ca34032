//! The flight's telemetry log.

use crate::record::{RecordError, RunFolder};
use mavlink_bridge::{Counters, TlogWriter, frames};

/// Every MAVLink frame of a flight, as a tlog in memory until the flight is over: a minute of five vehicles is two
/// thirds of a megabyte.
pub struct Log {
    tlog: TlogWriter<Vec<u8>>,
}

impl Default for Log {
    fn default() -> Self {
        Self { tlog: TlogWriter::new(Vec::new()) }
    }
}

impl Log {
    /// Keeps one frame.
    pub fn frame(&mut self, at_us: u64, bytes: &[u8]) {
        // Writing into memory cannot fail.
        let _ = self.tlog.write(at_us, bytes);
    }

    /// Keeps the frames of a datagram of our own.
    pub fn datagram(&mut self, at_us: u64, datagram: &[u8]) {
        for frame in frames(datagram, &mut Counters::default()) {
            self.frame(at_us, frame.bytes);
        }
    }

    /// Writes `flight.tlog`.
    pub fn write(self, folder: &RunFolder) -> Result<(), RecordError> {
        folder.write("flight.tlog", &self.tlog.finish().unwrap_or_default())
    }
}
