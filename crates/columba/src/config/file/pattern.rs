//! `[vehicles]`: starts of many vehicles by a pattern.

use crate::config::swarm::Place;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Many vehicles' starts.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PatternTable {
    /// How many; as many as the file has where absent.
    pub count: Option<usize>,
    /// How they are laid out.
    #[serde(default)]
    pub pattern: Pattern,
    /// The file of [`Pattern::File`].
    pub file: Option<PathBuf>,
    /// What is in it, once it has been read.
    #[serde(skip)]
    pub places: Vec<Place>,
    /// Between neighbours, m.
    #[serde(default = "twelve")]
    pub spacing_m: f64,
    /// Northing of the pattern's front, m.
    #[serde(default)]
    pub x_m: f64,
    /// Easting of the pattern's middle, m.
    #[serde(default)]
    pub y_m: f64,
    /// Above the origin, m; the expected one where absent.
    pub altitude_m: Option<f64>,
    /// Horizontal speed, m/s; the expected one where absent.
    pub speed_mps: Option<f64>,
    /// Degrees from north towards east; the expected one where absent.
    pub course_deg: Option<f64>,
    /// Each altitude differs from that by up to so much, at random by the seed, m.
    #[serde(default)]
    pub altitude_spread_m: f64,
    /// The same of speeds, m/s.
    #[serde(default)]
    pub speed_spread_mps: f64,
    /// The same of courses, degrees.
    #[serde(default)]
    pub course_spread_deg: f64,
}

fn twelve() -> f64 {
    PatternTable::DEFAULT.spacing_m
}

impl PatternTable {
    /// How many, once a swarm file has been read.
    pub fn count(&self) -> usize {
        self.count.unwrap_or(self.places.len())
    }

    /// One vehicle at the origin.
    pub const DEFAULT: Self = Self {
        count: Some(1),
        pattern: Pattern::Grid,
        file: None,
        places: Vec::new(),
        spacing_m: 12.0,
        x_m: 0.0,
        y_m: 0.0,
        altitude_m: None,
        speed_mps: None,
        course_deg: None,
        altitude_spread_m: 0.0,
        speed_spread_mps: 0.0,
        course_spread_deg: 0.0,
    };
}

/// How the starts of many vehicles are laid out; their centre is at (x_m, y_m), their front along the course.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, clap::ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Pattern {
    /// Abreast, square to the course.
    Line,
    /// Rows abreast, as square as the count allows.
    #[default]
    Grid,
    /// A V open to the rear.
    Wedge,
    /// Anywhere in a square as large as the grid's, no two nearer than half the spacing; by the scenario's seed.
    Random,
    /// As a file says, in the form of ArduPilot's swarminit.txt.
    #[value(skip)]
    File,
}
