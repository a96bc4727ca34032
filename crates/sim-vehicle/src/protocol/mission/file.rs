//! Plans that survive a restart: for each vehicle a text file of its mission, its fence and its rally points, in the
//! form "QGC WPL 110" that ground stations write and read
//! (<https://mavlink.io/en/file_formats/#mission_plain_text_file>). There is no file of an empty plan.

use super::check::check_items;
use crate::autopilot::plan::{PlanKind, Plans};
use crate::firmware::Personality;
use mavlink_bridge::PlanItem;
use std::fmt::Write as _;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;

const HEADER: &str = "QGC WPL 110";

/// Why a file of a plan cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PlanFileError {
    /// It cannot be opened, read or decoded.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A line is not what is expected there, or an item that no vehicle takes.
    #[error("{}:{line}: {reason}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
}

/// The file of a plan of the vehicle of an index in a folder.
pub(crate) fn path(folder: &Path, vehicle: usize, kind: PlanKind) -> PathBuf {
    folder.join(format!("vehicle-{}-{}.txt", vehicle + 1, kind.name().to_lowercase()))
}

/// All plans of the vehicle of an index; those without a file are empty.
pub(crate) fn read(folder: &Path, vehicle: usize, personality: Personality) -> Result<Plans, PlanFileError> {
    let mut plans = Plans::default();
    for kind in PlanKind::ALL {
        let path = path(folder, vehicle, kind);
        match std::fs::read_to_string(&path) {
            Ok(text) => {
                let found = parse(kind, &text, personality);
                *plans.of(kind) = found.map_err(|(line, reason)| PlanFileError::Line { path, line, reason })?;
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(source) => return Err(PlanFileError::Io { path, source }),
        }
    }
    Ok(plans)
}

/// Writes a file whole, or leaves the old one as it was.
pub(crate) fn write(path: &Path, items: &[PlanItem]) -> io::Result<()> {
    if items.is_empty() {
        return match std::fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        };
    }
    let unfinished = path.with_extension("txt.new");
    std::fs::write(&unfinished, text(items))?;
    std::fs::rename(unfinished, path)
}

fn text(items: &[PlanItem]) -> String {
    let mut text = format!("{HEADER}\n");
    for (seq, item) in items.iter().enumerate() {
        let PlanItem { params: [p1, p2, p3, p4], z_m, command, frame, autocontinue, .. } = item;
        let [latitude, longitude] = [item.latitude_e7, item.longitude_e7].map(degrees);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{seq}\t0\t{frame}\t{command}\t{p1}\t{p2}\t{p3}\t{p4}\t{latitude}\t{longitude}\t{z_m}\t{autocontinue}"
        );
    }
    text
}

/// Exactly: the seven decimals are all there is.
fn degrees(e7: i32) -> String {
    let (sign, size) = (if e7 < 0 { "-" } else { "" }, e7.unsigned_abs());
    format!("{sign}{}.{:07}", size / 10_000_000, size % 10_000_000)
}

/// The items, or the line from 1 that is wrong, and why.
fn parse(kind: PlanKind, text: &str, personality: Personality) -> Result<Vec<PlanItem>, (usize, String)> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header = lines.next();
    if header.is_none_or(|(_, line)| line.trim() != HEADER) {
        return Err((header.map_or(1, |(index, _)| index + 1), format!("expected {HEADER:?}")));
    }
    let mut items = Vec::new();
    let mut numbers = Vec::new();
    for (index, line) in lines {
        items.push(item(line, items.len()).map_err(|reason| (index + 1, reason))?);
        numbers.push(index + 1);
    }
    let at = |seq: usize| numbers.get(seq).or(numbers.last()).copied().unwrap_or(1);
    // Whether item 0 is home is the vehicle's to say, which looks at them again.
    check_items(personality.rules(), kind, &items).map_err(|(seq, reason)| (at(seq), reason))?;
    Ok(items)
}

fn item(line: &str, seq: usize) -> Result<PlanItem, String> {
    let fields: Vec<&str> = line.split_whitespace().collect();
    let Ok([index, _, frame, command, p1, p2, p3, p4, latitude, longitude, z, autocontinue]) =
        <[&str; 12]>::try_from(fields.as_slice())
    else {
        return Err(format!("expected 12 fields, found {}", fields.len()));
    };
    if number::<usize>(index)? != seq {
        return Err(format!("expected item {seq}, found {index}"));
    }
    Ok(PlanItem {
        params: [number(p1)?, number(p2)?, number(p3)?, number(p4)?],
        latitude_e7: degrees_e7(latitude)?,
        longitude_e7: degrees_e7(longitude)?,
        z_m: number(z)?,
        command: number(command)?,
        frame: number(frame)?,
        autocontinue: number(autocontinue)?,
    })
}

fn number<T: FromStr>(field: &str) -> Result<T, String> {
    field.parse().map_err(|_| format!("{field:?} is not a number that can stand there"))
}

fn degrees_e7(field: &str) -> Result<i32, String> {
    let degrees: f64 = number(field)?;
    if degrees.abs() <= 180.0 {
        Ok((degrees * 1e7).round() as i32)
    } else {
        Err(format!("{field} is no place on earth"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_written_is_read_to_the_last_bit(
            params in prop::array::uniform4(any::<f32>().prop_filter("NaN is not itself", |p| !p.is_nan())),
            latitude_e7 in -900_000_000..=900_000_000i32, longitude_e7 in -1_800_000_000..=1_800_000_000i32,
            z_m in -1e4..1e4f32, command: u16, frame: u8, autocontinue: u8,
        ) {
            let written = PlanItem { params, latitude_e7, longitude_e7, z_m, command, frame, autocontinue };
            let text = text(&[written]);
            prop_assert_eq!(item(text.lines().nth(1).unwrap(), 0), Ok(written));
        }
    }

    fn rally(latitude_e7: i32) -> PlanItem {
        PlanItem { command: 5100, frame: 3, latitude_e7, z_m: 50.0, ..PlanItem::default() }
    }

    #[test]
    fn plans_are_kept_in_files_of_their_own_and_empty_ones_in_none() {
        let folder = tempfile::tempdir().unwrap();
        let points = vec![rally(-5), rally(7)];
        let path = path(folder.path(), 1, PlanKind::Rally);
        assert!(path.ends_with("vehicle-2-rally.txt"));
        write(&path, &points).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        assert_eq!(
            read(folder.path(), 1, Personality::ArduPlane).unwrap(),
            Plans { rally: points, ..Plans::default() }
        );
        assert_eq!(read(folder.path(), 0, Personality::ArduPlane).unwrap(), Plans::default());
        (0..2).for_each(|_| write(&path, &[]).unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn ground_stations_files_are_read() {
        let line = "0\t1\t0\t16\t0.000000\tnan\t0.0\t0\t-35.3632621\t149.1652374\t584.090027\t1";
        let found = parse(PlanKind::Mission, &format!("{HEADER}\r\n{line}\r\n\n"), Personality::ArduPlane).unwrap();
        assert_eq!((found[0].latitude_e7, found[0].longitude_e7), (-353_632_621, 1_491_652_374));
        assert!(found[0].params[1].is_nan());
    }

    #[test]
    fn nonsense_is_named_by_its_line() {
        let good = "0 0 3 5100 0 0 0 0 1.0 2.0 50 1";
        for (text, line, reason) in [
            ("", 1, "expected \"QGC WPL 110\"".to_owned()),
            ("QGC WPL 120\n", 1, "expected \"QGC WPL 110\"".to_owned()),
            ("QGC WPL 110\n\n0 0 3", 3, "expected 12 fields, found 3".to_owned()),
            ("QGC WPL 110\n1 0 3 5100 0 0 0 0 1.0 2.0 50 1", 2, "expected item 0, found 1".to_owned()),
            ("QGC WPL 110\n0 0 3 5100 0 0 0 0 1.0 200 50 1", 2, "200 is no place on earth".to_owned()),
            (
                "QGC WPL 110\n0 0 3 70000 0 0 0 0 1 2 50 1",
                2,
                "\"70000\" is not a number that can stand there".to_owned(),
            ),
            (
                &format!("{HEADER}\n{good}\n1 0 3 16 0 0 0 0 1 2 50 1"),
                3,
                "Rally refused: unsupported: item 1".to_owned(),
            ),
        ] {
            assert_eq!(parse(PlanKind::Rally, text, Personality::ArduPlane), Err((line, reason)));
        }
    }
}
