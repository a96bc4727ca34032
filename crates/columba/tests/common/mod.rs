//! The built program, driven as a user would.
#![allow(dead_code)] // each test file uses what it needs

use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// One UAV flies two seconds past a circle.
pub const SMALL: &str = r#"[scenario]
name = "small"
duration_s = 2.0

[flock]
expected_speed_mps = 10.0
expected_altitude_m = 50.0

[[vehicle]]
x_m = 0.0
y_m = 0.0
altitude_m = 50.0
speed_mps = 10.0

[[obstacle]]
x_m = 70.0
y_m = 20.0
radius_m = 8.0
"#;

/// A folder of its own, in which the program runs.
pub struct Room {
    folder: tempfile::TempDir,
}

/// What the program said, and its exit status.
#[derive(Debug)]
pub struct Said {
    pub status: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Room {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).expect("a file of a test");
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// A summary by its names.
    pub fn summary(&self, folder: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(&format!("{folder}/summary.json"))).expect("JSON")
    }

    /// The program, in this folder.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_columba"));
        command.args(arguments).current_dir(self.folder.path()).env_remove("RUST_LOG");
        command
    }

    pub fn columba(&self, arguments: &[&str]) -> Said {
        self.command(arguments).output().expect("the program starts").into()
    }

    /// Every file below this folder, sorted.
    pub fn files(&self) -> Vec<String> {
        let mut files = Vec::new();
        collect(self.folder.path(), self.folder.path(), &mut files);
        files.sort();
        files
    }
}

fn collect(root: &Path, folder: &Path, files: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.strip_prefix(root).expect("below the root").display().to_string();
        if path.is_dir() {
            // An empty folder is something that is left behind, too.
            let before = files.len();
            collect(root, &path, files);
            if files.len() == before {
                files.push(name + "/");
            }
        } else {
            files.push(name);
        }
    }
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
        Self { status: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }
}

impl Said {
    /// Asserts the exit status and gives what was said.
    #[track_caller]
    pub fn with(self, status: i32) -> Self {
        assert_eq!(self.status, Some(status), "{self:?}");
        self
    }

    /// Asserts that the arguments or a file were refused, with one message that holds these words.
    #[track_caller]
    pub fn refused(self, words: &[&str]) {
        let said = self.with(2);
        assert!(said.out.is_empty(), "{said:?}");
        for word in words {
            assert!(said.err.contains(word), "{said:?}\nshould say: {word}");
        }
    }
}

/// A port that stays busy while the socket lives.
pub fn busy_port() -> (UdpSocket, u16) {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a free port");
    let port = socket.local_addr().expect("an address").port();
    (socket, port)
}

/// The first of some ports in a row that were free a moment ago.
pub fn free_ports(count: u16) -> u16 {
    (0..50)
        .find_map(|_| {
            let (_first, port) = busy_port();
            let rest: Result<Vec<UdpSocket>, _> =
                (1..count).map(|next| UdpSocket::bind(("127.0.0.1", port.saturating_add(next)))).collect();
            rest.is_ok().then_some(port)
        })
        .expect("free ports in a row")
}
