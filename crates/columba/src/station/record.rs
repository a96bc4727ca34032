//! The record is on disk as it flies: `flight.tlog` with every frame at its own time, and `flight.journal` with every
//! tick and event, a line of JSON each. A full disk does not end the flight. `columba recover` makes the rest of a
//! folder from them.

use super::told::Event;
use crate::flight::{Field, Flight, Obstacle, Row, Setting, Summary, Tick, Trajectory};
use flight_model::{Setpoint, State};
use mavlink_bridge::TlogWriter;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

/// What is written is on disk after this.
const FLUSH: Duration = Duration::from_millis(200);

/// Names of the files.
pub const TLOG: &str = "flight.tlog";
/// The journal's name.
pub const JOURNAL: &str = "flight.journal";

enum Item {
    Frame(u64, Vec<u8>),
    Line(Value),
}

/// Writes a record on a thread of its own: a slow disk delays no command.
pub struct Recording {
    items: Option<Sender<Item>>,
    trouble: Arc<Mutex<Option<String>>>,
    thread: Option<JoinHandle<()>>,
}

impl Recording {
    /// Begins the files of a folder. Those of a flight that was not concluded are kept under another name.
    ///
    /// # Errors
    /// When a file cannot be made.
    pub fn begin(folder: &Path) -> io::Result<Self> {
        keep_unfinished(folder)?;
        let tlog = TlogWriter::new(File::create(folder.join(TLOG))?);
        let journal = BufWriter::new(File::create(folder.join(JOURNAL))?);
        let (items, taker) = channel();
        let trouble = Arc::new(Mutex::new(None));
        let told = Arc::clone(&trouble);
        let thread = std::thread::Builder::new().name("record".to_owned()).spawn(move || {
            write(&taker, tlog, journal, &told);
        })?;
        Ok(Self { items: Some(items), trouble, thread: Some(thread) })
    }

    /// Keeps a frame as it was on the wire, at a time in microseconds since the Unix epoch.
    pub fn frame(&self, at_us: u64, bytes: &[u8]) {
        self.put(Item::Frame(at_us, bytes.to_vec()));
    }

    /// Keeps a line of the journal.
    pub fn line(&self, line: Value) {
        self.put(Item::Line(line));
    }

    /// Why nothing is written any more, once; the flight goes on.
    pub fn take_trouble(&self) -> Option<String> {
        self.trouble.lock().ok()?.take()
    }

    /// Writes what is left.
    pub fn end(mut self) {
        self.items = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }

    fn put(&self, item: Item) {
        if let Some(items) = &self.items {
            let _ = items.send(item);
        }
    }
}

fn write(
    taker: &Receiver<Item>,
    mut tlog: TlogWriter<File>,
    mut journal: BufWriter<File>,
    told: &Mutex<Option<String>>,
) {
    let mut works = true;
    loop {
        let written = match taker.recv_timeout(FLUSH) {
            Ok(Item::Frame(at_us, bytes)) if works => tlog.write(at_us, &bytes),
            Ok(Item::Line(line)) if works => serde_json::to_writer(&mut journal, &line)
                .map_err(io::Error::from)
                .and_then(|()| journal.write_all(b"\n"))
                .and_then(|()| journal.flush())
                .and_then(|()| tlog.flush()),
            Ok(_) => Ok(()),
            Err(RecvTimeoutError::Timeout) if works => tlog.flush().and_then(|()| journal.flush()),
            Err(RecvTimeoutError::Timeout) => Ok(()),
            Err(RecvTimeoutError::Disconnected) => {
                let _ = tlog.flush().and_then(|()| journal.flush());
                return;
            }
        };
        if let Err(error) = written {
            works = false;
            if let Ok(mut told) = told.lock() {
                *told = Some(format!("the record cannot be written any more: {error}"));
            }
        }
    }
}

/// Moves the files of a flight that was not concluded out of the way.
fn keep_unfinished(folder: &Path) -> io::Result<()> {
    let journal = folder.join(JOURNAL);
    let is_concluded = |path: &Path| -> io::Result<bool> {
        let lines = BufReader::new(File::open(path)?).lines();
        Ok(lines.map_while(Result::ok).last().is_some_and(|line| line.contains("\"end\"")))
    };
    if !journal.exists() || is_concluded(&journal)? {
        return Ok(());
    }
    let free = (1..10_000).find(|number| !folder.join(format!("{JOURNAL}.{number}")).exists()).unwrap_or(10_000);
    for name in [JOURNAL, TLOG] {
        if folder.join(name).exists() {
            std::fs::rename(folder.join(name), folder.join(format!("{name}.{free}")))?;
        }
    }
    Ok(())
}

/// The first line of a journal: what flies, and through what.
pub fn header_line(summary: &Summary, field: &Field, settings: &[Setting]) -> Value {
    let obstacles: Vec<Value> =
        field.obstacles.iter().map(|circle| json!([circle.x_m, circle.y_m, circle.radius_m])).collect();
    let settings: Vec<Value> = settings.iter().map(|setting| json!([setting.name, setting.value])).collect();
    json!({"header": {
        "summary": summary,
        "obstacles": obstacles,
        "expected": [field.expected.speed_mps, field.expected.course_rad, field.expected.altitude_m],
        "safe_distance_m": field.safe_distance_m,
        "collision_distance_m": field.collision_distance_m,
        "settings": settings,
    }})
}

/// A tick: what was flown, and what was then asked. What is not known is null.
pub fn tick_line(t_s: f64, [min_separation_m, min_clearance_m]: [f64; 2], rows: &[Row]) -> Value {
    let numbers = |row: &Row| {
        let Row { state: s, setpoint: p, alpha } = row;
        json!([
            s.x_m,
            s.y_m,
            s.altitude_m,
            s.speed_mps,
            s.course_rad,
            s.climb_mps,
            p.speed_mps,
            p.course_rad,
            p.altitude_m,
            alpha[0],
            alpha[1],
            alpha[2]
        ])
    };
    let rows: Vec<Value> = rows.iter().map(numbers).collect();
    json!({"tick": {"t_s": t_s, "min_separation_m": min_separation_m, "min_clearance_m": min_clearance_m, "rows": rows}})
}

/// An event.
pub fn event_line(event: &Event) -> Value {
    json!({ "event": event })
}

/// The last line.
pub fn end_line() -> Value {
    json!({"end": true})
}

/// Why a folder cannot be recovered.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// The journal cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The journal.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The journal has no header.
    #[error("{}: line 1 is no header of a flight: there is nothing to recover", path.display())]
    Header {
        /// The journal.
        path: PathBuf,
    },
}

/// The flight in a journal, as far as it was written.
///
/// # Errors
/// When there is no journal, or it has no header.
pub fn recover(folder: &Path) -> Result<Flight, RecoverError> {
    let path = folder.join(JOURNAL);
    let file = File::open(&path).map_err(|source| RecoverError::Read { path: path.clone(), source })?;
    // A line that was cut ends the journal.
    let mut lines =
        BufReader::new(file).lines().map_while(Result::ok).map_while(|line| serde_json::from_str::<Value>(&line).ok());
    let header = lines.next().and_then(|mut line| line.get_mut("header").map(Value::take));
    let mut header = header.ok_or_else(|| RecoverError::Header { path: path.clone() })?;
    let summary = header.get_mut("summary").map(Value::take).unwrap_or_default();
    let mut summary: Summary = serde_json::from_value(summary).map_err(|_| RecoverError::Header { path })?;
    let mut flight = Flight {
        field: field(&header),
        settings: settings(&header),
        trajectory: Trajectory::new(summary.vehicles),
        ..Flight::default()
    };
    let mut events = Vec::new();
    for mut line in lines {
        if let Some(tick) = line.get("tick") {
            push(&mut flight.trajectory, tick);
        } else if let Some(event) = line.get_mut("event") {
            events.push(event.take());
        }
    }
    let ticks = &flight.trajectory.ticks;
    let least = |value: fn(&Tick) -> f64| {
        let least = ticks.iter().filter(|tick| value(tick).is_finite()).min_by(|a, b| value(a).total_cmp(&value(b)));
        least.map(|tick| (value(tick), tick.t_s))
    };
    let (separation, clearance) = (least(|tick| tick.min_separation_m), least(|tick| tick.min_clearance_m));
    summary.duration_s = ticks.last().map_or(0.0, |tick| tick.t_s);
    summary.min_separation_m = separation.map(|(value_m, _)| value_m);
    summary.min_separation_at_s = separation.map(|(_, at_s)| at_s);
    summary.min_clearance_m = clearance.map(|(value_m, _)| value_m);
    summary.min_clearance_at_s = clearance.map(|(_, at_s)| at_s);
    summary.obstacle_collisions = u32::from(clearance.is_some_and(|(value_m, _)| value_m < 0.0));
    summary.vehicle_collisions =
        u32::from(separation.is_some_and(|(value_m, _)| value_m < flight.field.collision_distance_m));
    (summary.completed, summary.success) = (false, false);
    summary.failure = Some(format!("recovered: the program ended in flight, after {:.1} s", summary.duration_s));
    summary.station = json!({ "events": events });
    flight.summary = summary;
    Ok(flight)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn numbers(value: Option<&Value>) -> Vec<f64> {
    value.and_then(Value::as_array).map(|values| values.iter().map(number).collect()).unwrap_or_default()
}

fn field(header: &Value) -> Field {
    let circles = header.get("obstacles").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    let circle = |values: &Value| match numbers(Some(values))[..] {
        [x_m, y_m, radius_m] => Some(Obstacle { x_m, y_m, radius_m }),
        _ => None,
    };
    let expected = match numbers(header.get("expected"))[..] {
        [speed_mps, course_rad, altitude_m] => Setpoint { speed_mps, course_rad, altitude_m },
        _ => Setpoint::default(),
    };
    let distance = |name: &str| header.get(name).map_or(0.0, number);
    Field {
        obstacles: circles.iter().filter_map(circle).collect(),
        expected,
        safe_distance_m: distance("safe_distance_m"),
        collision_distance_m: distance("collision_distance_m"),
    }
}

fn settings(header: &Value) -> Vec<Setting> {
    let pairs = header.get("settings").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    let setting = |pair: &Value| {
        let text = |index: usize| pair.get(index).and_then(Value::as_str).map(str::to_owned);
        Some(Setting { name: text(0)?, value: text(1)? })
    };
    pairs.iter().filter_map(setting).collect()
}

fn push(trajectory: &mut Trajectory, tick: &Value) {
    let value = |name: &str| tick.get(name).map_or(f64::NAN, number);
    let rows = tick.get("rows").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
    let rows = rows.iter().map(|row| {
        let values = numbers(Some(row));
        let at = |index: usize| values.get(index).copied().unwrap_or(f64::NAN);
        Row {
            state: State {
                x_m: at(0),
                y_m: at(1),
                altitude_m: at(2),
                speed_mps: at(3),
                course_rad: at(4),
                climb_mps: at(5),
            },
            setpoint: Setpoint { speed_mps: at(6), course_rad: at(7), altitude_m: at(8) },
            alpha: [at(9), at(10), at(11)],
        }
    });
    let tick = Tick {
        t_s: value("t_s"),
        min_separation_m: value("min_separation_m"),
        min_clearance_m: value("min_clearance_m"),
        solve_us: 0.0,
    };
    trajectory.push(tick, rows);
}

/// The flight as the report can draw it: a vehicle that was not heard stays where it was heard last, and one that never
/// was, at the origin. The record keeps what is not known as such.
pub fn drawable(flight: &Flight) -> Flight {
    let mut drawn = flight.clone();
    let vehicles = drawn.trajectory.vehicles;
    let mut last = vec![Row::default(); vehicles];
    for (vehicle, last) in last.iter_mut().enumerate() {
        if let Some((_, first)) = flight.trajectory.vehicle(vehicle).find(|(_, row)| row.state.is_finite()) {
            *last = Row { setpoint: first.state.hold(), alpha: [0.0; 3], ..*first };
        }
    }
    for (index, row) in drawn.trajectory.rows.iter_mut().enumerate() {
        let last = &mut last[index % vehicles.max(1)];
        if !row.state.is_finite() {
            row.state = last.state;
        }
        if !row.setpoint.is_finite() {
            row.setpoint = last.setpoint;
        }
        if !row.alpha.iter().all(|alpha| alpha.is_finite()) {
            row.alpha = last.alpha;
        }
        *last = *row;
    }
    for tick in &mut drawn.trajectory.ticks {
        let known = |value: f64| if value.is_nan() { f64::INFINITY } else { value };
        (tick.min_separation_m, tick.min_clearance_m) = (known(tick.min_separation_m), known(tick.min_clearance_m));
    }
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(x_m: f64) -> Row {
        Row { state: State { x_m, speed_mps: 20.0, ..State::default() }, ..Row::default() }
    }

    fn unknown() -> Row {
        Row { state: State { x_m: f64::NAN, ..State::default() }, ..row(0.0) }
    }

    fn header() -> Value {
        let summary = Summary { vehicles: 2, scenario: "mine".to_owned(), ..Summary::default() };
        let field = Field { obstacles: vec![Obstacle { x_m: 1.0, y_m: 2.0, radius_m: 3.0 }], ..Field::default() };
        header_line(&summary, &field, &[Setting { name: "a.b".to_owned(), value: "1".to_owned() }])
    }

    #[test]
    fn a_flight_that_was_cut_off_is_recovered_to_its_last_whole_line() {
        let folder = tempfile::tempdir().unwrap();
        let recording = Recording::begin(folder.path()).unwrap();
        recording.line(header());
        recording.frame(1, &[0xFE, 0, 0, 0, 0, 0, 0, 0]);
        recording.line(tick_line(0.0, [20.0, 9.0], &[row(0.0), row(5.0)]));
        recording.line(tick_line(1.0, [10.0, 8.0], &[row(20.0), unknown()]));
        recording.end();
        let journal = folder.path().join(JOURNAL);
        let mut text = std::fs::read_to_string(&journal).unwrap();
        text.push_str("{\"tick\": {\"t_s\": 2.0, \"ro");
        std::fs::write(&journal, text).unwrap();
        let flight = recover(folder.path()).unwrap();
        assert_eq!((flight.summary.vehicles, flight.trajectory.ticks.len()), (2, 2));
        assert_eq!((flight.summary.min_separation_m, flight.summary.min_separation_at_s), (Some(10.0), Some(1.0)));
        assert!(!flight.summary.success && flight.summary.failure.as_ref().unwrap().contains("after 1.0 s"));
        assert_eq!(flight.trajectory.rows[2].state.x_m, 20.0);
        assert!(flight.trajectory.rows[3].state.x_m.is_nan(), "what was not heard stays unknown");
        assert_eq!(flight.field.obstacles.len(), 1);
        assert_eq!(drawable(&flight).trajectory.rows[3].state.x_m, 5.0);
        assert_eq!(std::fs::metadata(folder.path().join(TLOG)).unwrap().len(), 16);
        // Another flight into the same folder loses nothing of this one.
        Recording::begin(folder.path()).unwrap().end();
        assert!(folder.path().join("flight.journal.1").exists() && folder.path().join("flight.tlog.1").exists());
    }

    #[test]
    fn a_folder_without_a_journal_is_told() {
        let folder = tempfile::tempdir().unwrap();
        assert!(recover(folder.path()).unwrap_err().to_string().contains("flight.journal"));
        std::fs::write(folder.path().join(JOURNAL), "nothing\n").unwrap();
        assert!(recover(folder.path()).unwrap_err().to_string().contains("line 1"));
    }
}
