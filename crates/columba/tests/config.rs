//! Every scenario in `config/` is good and flies without collision.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)] // helpers of tests may, as tests may

use columba::config;
use columba::flying::{self, Progress};
use std::path::{Path, PathBuf};

fn scenarios() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|kind| kind == "toml")).collect();
    files.sort();
    files
}

#[test]
fn every_example_flies_in_memory_without_collision() {
    let files = scenarios();
    assert!(files.len() >= 3, "{files:?}");
    for path in files {
        let scenario = config::load(Some(&path), &[]).unwrap_or_else(|error| panic!("{error}"));
        // The folder of a run is named after the scenario: two of one name would write over each other.
        assert_eq!(path.file_stem().unwrap().to_str(), Some(scenario.name.as_str()));
        let progress = Progress::new(scenario.ticks(), scenario.control_period, true);
        let (_sender, stop) = tokio::sync::watch::channel(false);
        let summary = flying::fly_in_memory(&scenario, &progress, &stop).unwrap().summary;
        assert!(summary.success, "{}: {:?}", path.display(), summary.failure);
        assert_eq!((summary.obstacle_collisions, summary.vehicle_collisions), (0, 0), "{}", path.display());
        assert!(summary.duration_s >= scenario.duration.as_secs_f64());
    }
}

#[test]
fn gaps_of_the_second_field_let_a_uav_through() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/random12.toml");
    let scenario = config::load(Some(&path), &[]).unwrap();
    assert_eq!((scenario.starts.len(), scenario.obstacles.len()), (12, 10));
    for (index, a) in scenario.obstacles.iter().enumerate() {
        assert!((4.0..=14.0).contains(&a.radius_m));
        for b in &scenario.obstacles[..index] {
            assert!(a.clearance_m(b.centre_m()) - b.radius_m >= 14.0, "obstacle {}", index + 1);
        }
    }
}
