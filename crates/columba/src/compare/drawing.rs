//! A figure of a comparison: in its page, and in files of its own.

/// A figure of the page, and of a file.
pub struct Drawing {
    /// The file's name without an ending.
    pub file: String,
    /// What it shows.
    pub title: String,
    /// The drawing.
    pub svg: String,
}

/// A text as a part of a file's name.
pub fn file_part(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect()
}
