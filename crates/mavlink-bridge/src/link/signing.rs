//! MAVLink 2 signatures (<https://mavlink.io/en/guide/message_signing.html>).
//!
//! A signed frame ends with 13 bytes: the id of the link, a time stamp of 48 bits in units of 10 us since 2015-01-01,
//! and the first 48 bits of SHA-256 over the secret key and all that stands before.

use crate::frame::{CHECKSUM, SIGNATURE, SIGNED, V2_HEADER, V2_START, checksum, checksum_extra};
use crate::{Frame, Version};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fmt;
use std::time::Duration;

/// Seconds from the Unix epoch to 2015-01-01, where signatures begin to count.
const EPOCH: Duration = Duration::from_secs(1_420_070_400);
/// A sender that is new may be this much behind: one minute, in units of 10 us.
const NEW_SENDER_LATE_MAX: u64 = 6_000_000;

/// A secret of 32 bytes that both ends share. It never shows itself.
#[derive(Clone, PartialEq, Eq)]
pub struct SigningKey([u8; 32]);

/// Why a key cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyError {
    /// Neither 32 bytes nor 64 hexadecimal digits.
    #[error("a key must be 64 hexadecimal digits, or 32 bytes")]
    Length,
}

/// Why a frame is not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rejection {
    /// It has no signature.
    Unsigned,
    /// Its signature is not that of the key.
    Forged,
    /// Its time stamp is not newer than the last one of its sender, or too old for a new sender.
    Replayed,
}

/// What was rejected so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Rejected {
    /// Frames without a signature.
    pub unsigned: u64,
    /// Frames with a wrong signature.
    pub forged: u64,
    /// Frames that came again, or too late.
    pub replayed: u64,
}

impl Rejected {
    /// Counts a frame that was rejected.
    pub fn count(&mut self, rejection: Rejection) {
        match rejection {
            Rejection::Unsigned => self.unsigned += 1,
            Rejection::Forged => self.forged += 1,
            Rejection::Replayed => self.replayed += 1,
        }
    }
}

impl SigningKey {
    /// A key from the contents of a file: 32 bytes, or 64 hexadecimal digits with white space around them.
    ///
    /// # Errors
    /// When it is neither.
    pub fn from_file_contents(contents: &[u8]) -> Result<Self, KeyError> {
        if let Ok(raw) = contents.try_into() {
            return Ok(Self(raw));
        }
        let text = std::str::from_utf8(contents).map_err(|_| KeyError::Length)?.trim();
        if text.len() != 64 || !text.is_ascii() {
            return Err(KeyError::Length);
        }
        let mut key = [0; 32];
        for (byte, digits) in key.iter_mut().zip(text.as_bytes().chunks(2)) {
            let digits = std::str::from_utf8(digits).map_err(|_| KeyError::Length)?;
            *byte = u8::from_str_radix(digits, 16).map_err(|_| KeyError::Length)?;
        }
        Ok(Self(key))
    }

    /// The first 48 bits of SHA-256 over the key and what is signed.
    fn signature(&self, signed: &[u8]) -> [u8; 6] {
        let digest = Sha256::new().chain_update(self.0).chain_update(signed).finalize();
        let mut signature = [0; 6];
        signature.copy_from_slice(&digest[..6]);
        signature
    }
}

impl fmt::Debug for SigningKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SigningKey(..)")
    }
}

/// A time since the Unix epoch as a signature has it.
pub fn signing_time(since_unix_epoch: Duration) -> u64 {
    let since = since_unix_epoch.saturating_sub(EPOCH);
    (since.as_micros() / 10) as u64 & 0xFFFF_FFFF_FFFF
}

/// Signs what goes out and verifies what comes in, on all links of a station together: a frame that was accepted from
/// one link is a replay on every other.
#[derive(Clone, Debug)]
pub struct Signing {
    key: SigningKey,
    /// The last time stamp that was used or accepted.
    time: u64,
    /// The last time stamp of each sender: link id, system, component.
    senders: HashMap<(u8, u8, u8), u64>,
}

impl Signing {
    /// Signatures from `now` on (see [`signing_time`]).
    pub fn new(key: SigningKey, now: u64) -> Self {
        Self { key, time: now, senders: HashMap::new() }
    }

    /// Appends `frame` to `out` with a signature of the link with this number. A frame of MAVLink 1, or one that is
    /// signed already, is appended as it is.
    pub fn sign(&mut self, link_id: u8, frame: &[u8], now: u64, out: &mut Vec<u8>) {
        let Some(signed) = self.signed(link_id, frame, now) else {
            out.extend_from_slice(frame);
            return;
        };
        out.extend_from_slice(&signed);
    }

    fn signed(&mut self, link_id: u8, frame: &[u8], now: u64) -> Option<Vec<u8>> {
        let end = frame.len().checked_sub(CHECKSUM).filter(|&end| end >= V2_HEADER)?;
        if frame[0] != V2_START || frame[2] & SIGNED != 0 {
            return None;
        }
        let mut signed = frame[..end].to_vec();
        signed[2] |= SIGNED;
        let id = u32::from_le_bytes([signed[7], signed[8], signed[9], 0]);
        signed.extend_from_slice(&checksum(&signed[1..], checksum_extra(id)?).to_le_bytes());
        // Strictly newer each time, though two frames go out within 10 us.
        self.time = now.max(self.time + 1);
        signed.push(link_id);
        signed.extend_from_slice(&self.time.to_le_bytes()[..6]);
        let signature = self.key.signature(&signed);
        signed.extend_from_slice(&signature);
        Some(signed)
    }

    /// Whether a frame that came in at `now` is accepted.
    ///
    /// # Errors
    /// Why it is not.
    pub fn verify(&mut self, frame: &Frame<'_>, now: u64) -> Result<(), Rejection> {
        let is_signed = frame.header.version == Version::V2 && frame.bytes.get(2).is_some_and(|f| f & SIGNED != 0);
        let from = frame.bytes.len().checked_sub(SIGNATURE).filter(|_| is_signed).ok_or(Rejection::Unsigned)?;
        let (signed, signature) = frame.bytes.split_at(frame.bytes.len() - 6);
        // Of equal time whatever is wrong.
        let differing = self.key.signature(signed).iter().zip(signature).fold(0, |all, (a, b)| all | (a ^ b));
        if differing != 0 {
            return Err(Rejection::Forged);
        }
        let mut stamp = [0; 8];
        stamp[..6].copy_from_slice(&frame.bytes[from + 1..from + 7]);
        let stamp = u64::from_le_bytes(stamp);
        let sender = (frame.bytes[from], frame.header.system_id, frame.header.component_id);
        let is_new = match self.senders.get(&sender) {
            Some(&last) => stamp > last,
            None => stamp + NEW_SENDER_LATE_MAX >= self.time.max(now),
        };
        if !is_new {
            return Err(Rejection::Replayed);
        }
        self.senders.insert(sender, stamp);
        self.time = self.time.max(stamp);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Encoder;
    use crate::telemetry::ground_heartbeat;

    const NOW: u64 = 30_000_000_000_000;

    fn key(byte: u8) -> SigningKey {
        SigningKey([byte; 32])
    }

    fn signed(signing: &mut Signing, encoder: &mut Encoder, now: u64) -> Vec<u8> {
        let (mut plain, mut out) = (Vec::new(), Vec::new());
        encoder.encode(&ground_heartbeat(), &mut plain);
        signing.sign(3, &plain, now, &mut out);
        out
    }

    // Made by pymavlink 2.4.50: mav.signing.secret_key = bytes([7] * 32), link_id = 3, timestamp = NOW, sign_outgoing =
    // True, MAVLink(None, srcSystem=255, srcComponent=190), heartbeat_send(6, 8, 0, 0, 4).
    #[test]
    fn a_signed_frame_has_the_bytes_that_others_write() {
        let mut signing = Signing::new(key(7), NOW - 1);
        let mut encoder = Encoder::new(255, 190);
        let bytes = signed(&mut signing, &mut encoder, NOW);
        let hex: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, PYMAVLINK);
    }

    const PYMAVLINK: &str = "fd09010000ffbe000000000000000608000403dab00300e057eb481b4e1f757725d3";

    #[test]
    fn what_the_key_signed_is_accepted_once() {
        let (mut ground, mut vehicle) = (Signing::new(key(7), NOW), Signing::new(key(7), NOW));
        let mut encoder = Encoder::new(1, 1);
        let bytes = signed(&mut vehicle, &mut encoder, NOW);
        let frame = Frame::parse(&bytes).unwrap();
        assert_eq!(ground.verify(&frame, NOW), Ok(()));
        assert_eq!(ground.verify(&frame, NOW), Err(Rejection::Replayed));
        let next = signed(&mut vehicle, &mut encoder, NOW);
        assert_eq!(ground.verify(&Frame::parse(&next).unwrap(), NOW), Ok(()));
    }

    #[test]
    fn unsigned_forged_and_old_frames_are_rejected() {
        let mut ground = Signing::new(key(7), NOW);
        let mut plain = Vec::new();
        Encoder::new(1, 1).encode(&ground_heartbeat(), &mut plain);
        assert_eq!(ground.verify(&Frame::parse(&plain).unwrap(), NOW), Err(Rejection::Unsigned));
        let mut old = Vec::new();
        Encoder::new(1, 1).with_version(Version::V1).encode(&ground_heartbeat(), &mut old);
        assert_eq!(ground.verify(&Frame::parse(&old).unwrap(), NOW), Err(Rejection::Unsigned));
        let forged = signed(&mut Signing::new(key(8), NOW), &mut Encoder::new(1, 1), NOW);
        assert_eq!(ground.verify(&Frame::parse(&forged).unwrap(), NOW), Err(Rejection::Forged));
        let late = signed(&mut Signing::new(key(7), 0), &mut Encoder::new(1, 1), NOW - 2 * NEW_SENDER_LATE_MAX);
        assert_eq!(ground.verify(&Frame::parse(&late).unwrap(), NOW), Err(Rejection::Replayed));
    }

    #[test]
    fn rejections_are_counted() {
        let mut rejected = Rejected::default();
        for rejection in [Rejection::Unsigned, Rejection::Forged, Rejection::Forged, Rejection::Replayed] {
            rejected.count(rejection);
        }
        assert_eq!(rejected, Rejected { unsigned: 1, forged: 2, replayed: 1 });
    }

    #[test]
    fn a_changed_byte_is_a_forgery() {
        let bytes = signed(&mut Signing::new(key(7), NOW), &mut Encoder::new(1, 1), NOW);
        for index in bytes.len() - 13..bytes.len() {
            let mut changed = bytes.clone();
            changed[index] ^= 1;
            let frame = Frame::parse(&changed).unwrap();
            assert_eq!(Signing::new(key(7), NOW).verify(&frame, NOW), Err(Rejection::Forged), "{index}");
        }
    }

    #[test]
    fn keys_are_read_and_never_shown() {
        let hex = format!(" {}\n", "07".repeat(32));
        assert_eq!(SigningKey::from_file_contents(hex.as_bytes()), Ok(key(7)));
        assert_eq!(SigningKey::from_file_contents(&[7; 32]), Ok(key(7)));
        assert_eq!(SigningKey::from_file_contents(b"short"), Err(KeyError::Length));
        assert_eq!(SigningKey::from_file_contents("ä".repeat(32).as_bytes()), Err(KeyError::Length));
        assert_eq!(format!("{:?}", key(7)), "SigningKey(..)");
    }
}
