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
    pub fn write(&mut self, at_us: u64, frame_bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(&at_us.to_be_bytes())?;
        self.out.write_all(frame_bytes)
    }

    /// Writes what is buffered, and gives back what the log was written to. Without this, errors at the end are lost.
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
    /// What follows a time is no frame.
    #[error("byte {0:#04x} starts no frame")]
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
