//! Every file that a page or a comment names exists.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests may, as tests may

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders of the project whose files a name may mean, and the pages at its root.
const FOLDERS: [&str; 5] = ["crates", "config", "docs", "scripts", "tests"];
const PAGES: [&str; 3] = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Names that are no files of the project: what the program writes, tools of others, a reader's own files in the
/// README.
const NOT_OURS: [&str; 9] = [
    "table.md",
    "sim_vehicle.py",
    "mavlogdump.py",
    "mavproxy.py",
    "Tools/autotest/arduplane.py",
    "Tools/mavlink_shell.py",
    "Tools/mavlink_ulog_streaming.py",
    "my/tests/conftest.py",
    "my/tests/test_mine.py",
];

/// All files below the folders, as paths from the root.
fn files() -> BTreeSet<String> {
    let mut files: BTreeSet<String> = PAGES.map(str::to_owned).into();
    let mut folders: Vec<String> = FOLDERS.map(str::to_owned).into();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
            if entry.file_type().unwrap().is_dir() {
                folders.push(path);
            } else {
                files.insert(path);
            }
        }
    }
    files
}

/// The names of files in a text: words with the suffix of a source file or a page, or that begin with one of the
/// folders. `{a,b}` stands for both, as in a shell.
fn names(text: &str) -> Vec<String> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "_-./{},*".contains(c);
    let words = text.split(|c: char| !is_part(c)).map(|word| word.trim_end_matches(['.', ',']));
    words
        .filter(|word| !word.contains("//") && !word.contains('*'))
        .flat_map(expand)
        .filter(|name| is_file(name))
        .collect()
}

fn is_file(name: &str) -> bool {
    let in_a_folder = FOLDERS.iter().any(|folder| name.strip_prefix(folder).is_some_and(|rest| rest.starts_with('/')));
    let stem = name.rsplit('/').next().unwrap();
    let is_source = [".rs", ".md", ".py"].iter().any(|suffix| stem.len() > suffix.len() && stem.ends_with(suffix));
    is_source || in_a_folder && stem.contains('.') && !stem.starts_with('.')
}

fn expand(word: &str) -> Vec<String> {
    match (word.find('{'), word.find('}')) {
        (Some(open), Some(close)) if open < close => {
            let (before, after) = (&word[..open], &word[close + 1..]);
            word[open + 1..close].split(',').map(|choice| format!("{before}{choice}{after}")).collect()
        }
        _ => vec![word.trim_matches(['{', '}', ',']).to_owned()],
    }
}

/// The names that no file of the project ends with.
fn missing(text: &str, files: &BTreeSet<String>) -> Vec<String> {
    let exists = |name: &str| {
        let name = name.trim_start_matches("../").trim_start_matches("./");
        files.iter().any(|file| file.strip_suffix(name).is_some_and(|rest| rest.is_empty() || rest.ends_with('/')))
    };
    names(text).into_iter().filter(|name| !NOT_OURS.contains(&name.as_str()) && !exists(name)).collect()
}

#[test]
fn every_file_that_a_page_names_exists() {
    let files = files();
    let pages = files.iter().filter(|file| file.starts_with("docs/") && file.ends_with(".md"));
    let pages: Vec<&str> = pages.map(String::as_str).chain(["README.md", "CONTRIBUTING.md"]).collect();
    assert!(pages.len() > 8, "{pages:?}");
    let mut named = 0;
    for page in pages {
        let text = fs::read_to_string(root().join(page)).unwrap();
        named += names(&text).len();
        assert_eq!(missing(&text, &files), Vec::<String>::new(), "in {page}");
    }
    assert!(named > 50, "only {named} names");
}

#[test]
fn every_file_that_a_comment_names_exists() {
    let files = files();
    let mut named = 0;
    for file in files.iter().filter(|file| file.ends_with(".rs")) {
        let text = fs::read_to_string(root().join(file)).unwrap();
        let comments: String = text
            .lines()
            .map(str::trim_start)
            .filter(|line| line.starts_with("//"))
            .map(|line| format!("{line}\n"))
            .collect();
        // The slashes of the comment itself begin no name.
        let comments = comments.replace("///", " ").replace("//!", " ").replace("\n//", "\n ");
        named += names(&comments).len();
        assert_eq!(missing(&comments, &files), Vec::<String>::new(), "in {file}");
    }
    assert!(named > 20, "only {named} names");
}

#[test]
fn names_are_found_in_words_and_braces() {
    let text = "See `crates/a/src/{x,y}.rs`, docs/own.md. Not https://rustup.rs, not mine.toml, but config/paper.toml.";
    let expected = ["crates/a/src/x.rs", "crates/a/src/y.rs", "docs/own.md", "config/paper.toml"];
    assert_eq!(names(text), expected);
    assert_eq!(missing("terms.rs no_such_file.rs", &BTreeSet::from(["a/terms.rs".to_owned()])), ["no_such_file.rs"]);
}
