//! `summary.json`.

use crate::flight::Summary;

/// The summary as indented JSON with a newline at its end. Infinities and NaN become `null`.
pub fn summary_json(summary: &Summary) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(summary).map(|json| json + "\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_reads_back_as_it_was() {
        let summary = Summary {
            scenario: "quotes \" and </script>".into(),
            seed: u64::MAX,
            min_separation_m: Some(4.125),
            min_separation_vehicles: Some([2, 3]),
            solve_us_p50: 81.5,
            link: serde_json::json!({ "frames_lost": 3 }),
            ..Summary::default()
        };
        let json = summary_json(&summary).unwrap();
        assert_eq!(serde_json::from_str::<Summary>(&json).unwrap(), summary);
    }

    #[test]
    fn what_json_cannot_hold_is_null_and_reads_back() {
        let summary = Summary {
            min_separation_m: Some(f64::INFINITY),
            real_time_factor: f64::INFINITY,
            speed_convergence_s: None,
            ..Summary::default()
        };
        let json = summary_json(&summary).unwrap();
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        for name in ["min_separation_m", "real_time_factor", "speed_convergence_s", "link"] {
            assert_eq!(value.get(name), Some(&serde_json::Value::Null), "{name}");
        }
        let back: Summary = serde_json::from_str(&json).unwrap();
        assert_eq!(back.min_separation_m, None);
        assert!(back.real_time_factor.is_nan());
    }

    #[test]
    fn the_names_that_scripts_lean_on_are_there() {
        let value = serde_json::to_value(Summary::default()).unwrap();
        for name in [
            "scenario",
            "seed",
            "algorithm",
            "vehicles",
            "duration_s",
            "obstacle_collisions",
            "vehicle_collisions",
            "separation_losses",
            "min_clearance_m",
            "min_separation_m",
            "speed_convergence_s",
            "course_convergence_s",
            "solve_us_p50",
            "solve_us_p99",
            "wall_s",
            "real_time_factor",
        ] {
            assert!(value.get(name).is_some(), "{name}");
        }
    }
}
