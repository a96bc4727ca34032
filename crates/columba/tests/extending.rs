//! docs/extending.md against the code that it quotes.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests may, as tests may

use columba::config;
use std::path::Path;

const PAGE: &str = include_str!("../../../docs/extending.md");

fn lines(code: &str) -> Vec<&str> {
    code.lines().map(str::trim).filter(|line| !line.is_empty()).collect()
}

/// The blocks of a language, each with the text before it.
fn blocks(language: &str) -> Vec<(&'static str, &'static str)> {
    let opening = format!("```{language}\n");
    let mut from = 0;
    PAGE.match_indices(&opening)
        .map(|(start, _)| {
            let block = PAGE[start + opening.len()..].split("```").next().unwrap();
            let before = &PAGE[from..start];
            from = start;
            (before, block)
        })
        .collect()
}

#[test]
fn every_piece_of_code_is_quoted_from_the_file_that_was_named_last() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let quoted = blocks("rust");
    assert!(quoted.len() >= 9, "{}", quoted.len());
    let mut file = String::new();
    for (before, code) in quoted {
        // What an earlier section names is not meant.
        let before = before.rsplit("\n## ").next().unwrap();
        let named = before.split('`').filter(|name| name.starts_with("crates/") && name.ends_with(".rs"));
        // A file that is only mentioned stands after the one that is quoted.
        if let Some(name) = named.clone().find(|name| name.contains("/src/")) {
            file = std::fs::read_to_string(root.join(name)).unwrap();
        }
        let (code, file) = (lines(code), lines(&file));
        assert!(file.windows(code.len()).any(|window| window == code), "not quoted: {code:#?}");
    }
}

#[test]
fn its_contenders_are_settings_of_a_scenario() {
    let (_, toml) = blocks("toml")[0];
    for key in lines(toml).iter().filter_map(|line| line.strip_prefix("law.")) {
        let scenario = format!("{}\n[law]\n{key}\n", config::PAPER);
        let path = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(path.path(), scenario).unwrap();
        config::load(Some(path.path()), &[]).unwrap();
    }
}
