//! Telemetry logs (tlog): each frame after its time, as MAVProxy and pymavlink read them.
//!
//! A record is the time in microseconds since the Unix epoch, eight bytes big-endian, then the frame as on the wire.

use crate::{Frame, FrameError};
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};

/// Writes a tlog, buffered.
#[derive(Debug)]
pub struct TlogWriter<W: Write> {
    out: BufWriter<W>,
}

impl<W: Write> TlogWriter<W> {
    /// A log that is written to `out`.
    pub fn new(out: W) -> Self {
        Self { out: BufWriter::with_capacity(1 << 16, out) }
    }

    /// Writes one frame (see [`Frame::bytes`]) at a time in microseconds since the Unix epoch.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn write(&mut self, at_us: u64, frame_bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(&at_us.to_be_bytes())?;
        self.out.write_all(frame_bytes)
    }

    /// Writes what is buffered.
    ///
    /// # Errors
    /// What the output says.
    pub fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }

    /// Writes the rest of the buffer, and returns the output. Without this call, errors at the end are lost.
    ///
    /// # Errors
    /// The output cannot be written.
    pub fn finish(self) -> io::Result<W> {
        self.out.into_inner().map_err(io::IntoInnerError::into_error)
    }
}

/// One record of a tlog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TlogRecord {
    /// Time in microseconds since the Unix epoch.
    pub at_us: u64,
    /// The frame as on the wire. Its checksum has not been verified: [`TlogRecord::frame`] does.
    pub bytes: Vec<u8>,
}

impl TlogRecord {
    /// The frame.
    ///
    /// # Errors
    /// As [`Frame::parse`].
    pub fn frame(&self) -> Result<Frame<'_>, FrameError> {
        Frame::parse(&self.bytes)
    }
}

/// Why a tlog cannot be read on.
#[derive(Debug, thiserror::Error)]
pub enum TlogError {
    /// Reading failed.
    #[error("cannot read the log")]
    Io(#[from] io::Error),
    /// The log ends within a record, as it does when its writer was stopped.
    #[error("the log ends within a record")]
    Truncated,
    /// The bytes after a time are not a frame.
    #[error("no frame starts with byte {0:#04x}")]
    NotAFrame(u8),
}

/// Reads the records of a tlog one by one; ends after the first error.
#[derive(Debug)]
pub struct TlogReader<R: Read> {
    input: BufReader<R>,
    ended: bool,
}

impl<R: Read> TlogReader<R> {
    /// The log in `input`.
    pub fn new(input: R) -> Self {
        Self { input: BufReader::new(input), ended: false }
    }

    fn read_record(&mut self) -> Result<Option<TlogRecord>, TlogError> {
        if self.input.fill_buf()?.is_empty() {
            return Ok(None);
        }
        let mut time = [0; 8];
        self.read_whole(&mut time)?;
        let mut bytes = vec![0; 3];
        self.read_whole(&mut bytes)?;
        let length = Frame::length(bytes[0], bytes[1], bytes[2]).ok_or(TlogError::NotAFrame(bytes[0]))?;
        bytes.resize(length, 0);
        self.read_whole(&mut bytes[3..])?;
        Ok(Some(TlogRecord { at_us: u64::from_be_bytes(time), bytes }))
    }

    fn read_whole(&mut self, out: &mut [u8]) -> Result<(), TlogError> {
        self.input.read_exact(out).map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => TlogError::Truncated,
            _ => TlogError::Io(error),
        })
    }
}

impl<R: Read> Iterator for TlogReader<R> {
    type Item = Result<TlogRecord, TlogError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let record = self.read_record().transpose();
        self.ended = !matches!(record, Some(Ok(_)));
        record
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::telemetry::{ground_heartbeat, local_position_ned};
    use crate::{Encoder, Version};
    use flight_model::State;
    use std::time::Duration;

    /// Frames of both versions, with their times.
    fn records() -> Vec<TlogRecord> {
        let messages = [ground_heartbeat(), local_position_ned(Duration::from_secs(1), &State::default())];
        let mut encoders = [Version::V1, Version::V2].map(|version| Encoder::new(3, 1).with_version(version));
        let mut records = Vec::new();
        for (index, message) in messages.iter().cycle().take(400).enumerate() {
            let mut bytes = Vec::new();
            encoders[index / 2 % 2].encode(message, &mut bytes);
            records.push(TlogRecord { at_us: 1_700_000_000_000_000 + 20_000 * index as u64, bytes });
        }
        records
    }

    fn log(records: &[TlogRecord]) -> Vec<u8> {
        let mut writer = TlogWriter::new(Vec::new());
        for record in records {
            writer.write(record.at_us, &record.bytes).unwrap();
        }
        writer.finish().unwrap()
    }

    #[test]
    fn what_is_written_is_read() {
        let records = records();
        let read: Vec<_> = TlogReader::new(&log(&records)[..]).collect::<Result<_, _>>().unwrap();
        assert_eq!(read, records);
        assert!(read.iter().all(|record| record.frame().is_ok_and(|frame| frame.bytes == record.bytes)));
    }

    #[test]
    fn a_file_round_trip_on_disk() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.tlog");
        let records = records();
        let mut writer = TlogWriter::new(std::fs::File::create(&path).unwrap());
        for record in &records {
            writer.write(record.at_us, &record.bytes).unwrap();
        }
        writer.finish().unwrap();
        let read = TlogReader::new(std::fs::File::open(&path).unwrap()).collect::<Result<Vec<_>, _>>().unwrap();
        assert_eq!(read, records);
    }

    #[test]
    fn the_time_is_big_endian_before_the_frame() {
        let bytes = log(&[TlogRecord { at_us: 0x0102_0304_0506_0708, bytes: vec![0xFE, 0, 0, 0, 0, 0, 0, 0] }]);
        assert_eq!(bytes, [1, 2, 3, 4, 5, 6, 7, 8, 0xFE, 0, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn a_log_cut_anywhere_gives_its_whole_records() {
        let records = &records()[..4];
        let whole = log(records);
        let mut ends = vec![0];
        for record in records {
            ends.push(ends[ends.len() - 1] + 8 + record.bytes.len());
        }
        for length in 0..whole.len() {
            let read: Vec<_> = TlogReader::new(&whole[..length]).collect();
            let complete = ends.iter().filter(|&&end| end > 0 && end <= length).count();
            assert_eq!(read.iter().filter(|record| record.is_ok()).count(), complete);
            let cut_within = !ends.contains(&length);
            assert_eq!(matches!(read.last(), Some(Err(TlogError::Truncated))), cut_within, "{length}");
        }
    }

    #[test]
    fn what_is_no_log_is_said_so() {
        let read: Vec<_> = TlogReader::new(&[0_u8; 64][..]).collect();
        assert!(matches!(read[..], [Err(TlogError::NotAFrame(0))]));
    }

    #[test]
    fn errors_at_the_end_are_reported() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let mut writer = TlogWriter::new(Full);
        writer.write(0, &[0xFE]).unwrap();
        assert_eq!(writer.finish().err().map(|error| error.kind()), Some(io::ErrorKind::StorageFull));
    }
}
