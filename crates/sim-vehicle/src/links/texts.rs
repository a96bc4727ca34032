//! Words for everybody, however long.

use super::Links;
use mavlink_bridge::Version;
use mavlink_bridge::dialect::{MavSeverity, Message, STATUSTEXT_DATA};

/// Bytes of a STATUSTEXT.
const TEXT_MAX: usize = 50;

impl Links {
    /// Says something to everybody: in MAVLink 2 as long as it is, in MAVLink 1 no more than fits
    /// (<https://mavlink.io/en/messages/common.html#STATUSTEXT>).
    pub fn say(&mut self, severity: MavSeverity, text: &str) {
        let id = if text.len() > TEXT_MAX {
            self.long_texts = self.long_texts.checked_add(1).unwrap_or(1);
            self.long_texts
        } else {
            0
        };
        let mut chunks: Vec<&[u8]> = text.as_bytes().chunks(TEXT_MAX).collect();
        // A chunk that is not full is the last one.
        if id != 0 && text.len().is_multiple_of(TEXT_MAX) {
            chunks.push(&[]);
        }
        for (chunk_seq, chunk) in (0..u8::MAX).zip(chunks) {
            let text = String::from_utf8_lossy(chunk);
            let message = Message::STATUSTEXT(STATUSTEXT_DATA { severity, text: text.as_ref().into(), id, chunk_seq });
            for index in 0..self.links.len() {
                if chunk_seq == 0 || self.links[index].encoder.version == Version::V2 {
                    self.send(index, &message);
                }
            }
        }
    }
}
