//! Swarm files: starts of many vehicles, in the form of ArduPilot's `Tools/autotest/swarminit.txt`, which its
//! `sim_vehicle.py --swarm` reads: `instance=east,north,up,heading`, the first three in metres from home, the heading
//! in degrees; what follows a `#` is not read.

use super::source::{ConfigError, Source};
use flight_model::{State, wrap_pi};
use nalgebra::Vector2;
use std::collections::BTreeMap;
use std::path::Path;

/// Where one vehicle starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// East of home, m.
    pub east_m: f64,
    /// North of home, m.
    pub north_m: f64,
    /// Above home, m.
    pub up_m: f64,
    /// Degrees from north towards east.
    pub heading_deg: f64,
}

/// What the numbers of a line are called, with the greatest magnitude of each.
const NUMBERS: [(&str, f64); 4] = [("east", 100_000.0), ("north", 100_000.0), ("up", 20_000.0), ("heading", 360.0)];

/// Reads a swarm file: the places in the order of their instances.
///
/// # Errors
/// One line for the first fault, which names file, line, column, value and what would be right.
pub fn read(path: &Path) -> Result<Vec<Place>, ConfigError> {
    let source = Source::read(path, "a swarm file, a line instance=east,north,up,heading for each vehicle")?;
    let name = source.name();
    // By instance, each with the line that it stands in.
    let mut places: BTreeMap<u32, (usize, Place)> = BTreeMap::new();
    for (line, text) in source.text().lines().enumerate().map(|(index, text)| (index + 1, text)) {
        let content = text.split('#').next().unwrap_or_default();
        if content.trim().is_empty() {
            continue;
        }
        let (instance, place) = parse(content).map_err(|(at, what)| {
            // Columns as an editor counts them.
            let column = 1 + content.get(..at).unwrap_or_default().chars().count();
            ConfigError::new(vec![format!("{name}:{line}:{column}: {what}")])
        })?;
        if let Some((first, _)) = places.get(&instance) {
            let what = format!("instance {instance} is in line {first} already: must be there once");
            return Err(ConfigError::new(vec![format!("{name}:{line}:1: {what}")]));
        }
        places.insert(instance, (line, place));
    }
    if places.is_empty() {
        return Err(ConfigError::new(vec![format!("{name}: holds no vehicle: must have a line such as 1=20,20,0,90")]));
    }
    Ok(places.into_values().map(|(_, place)| place).collect())
}

impl Place {
    /// The start of this vehicle, with home at a position (north, east) in m; it flies as fast as `like` does.
    pub fn start(&self, home_m: Vector2<f64>, like: &State) -> State {
        State {
            x_m: home_m.x + self.north_m,
            y_m: home_m.y + self.east_m,
            altitude_m: like.altitude_m + self.up_m,
            course_rad: wrap_pi(self.heading_deg.to_radians()),
            ..*like
        }
    }
}

/// The instance and the place of a line; else the byte at which it is wrong, and how.
fn parse(line: &str) -> Result<(u32, Place), (usize, String)> {
    let Some((instance, numbers)) = line.split_once('=') else {
        return Err((0, format!("`{}`: must be instance=east,north,up,heading", line.trim())));
    };
    let instance = instance
        .trim()
        .parse()
        .map_err(|_| (0, format!("instance `{}`: must be a whole number, 0 or greater", instance.trim())))?;
    let mut at = line.len() - numbers.len();
    let mut values = [0.0; NUMBERS.len()];
    let mut words = numbers.split(',');
    for (value, (name, most)) in values.iter_mut().zip(NUMBERS) {
        let Some(word) = words.next() else {
            return Err((line.trim_end().len(), format!("{name} is missing: must be instance=east,north,up,heading")));
        };
        let number = word.trim().parse().ok().filter(|number: &f64| number.abs() <= most);
        *value =
            number.ok_or_else(|| (at, format!("{name} = {}: must be a number from -{most} to {most}", word.trim())))?;
        at += word.len() + 1;
    }
    if words.next().is_some() {
        return Err((at - 1, "a fifth number: must be instance=east,north,up,heading".to_owned()));
    }
    let [east_m, north_m, up_m, heading_deg] = values;
    Ok((instance, Place { east_m, north_m, up_m, heading_deg }))
}
