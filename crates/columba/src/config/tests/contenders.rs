//! Tests of what is laid over a scenario: where faults are told, and that laying changes nothing else.

use super::*;
use crate::config::contender::contenders;
use optimizer::Algorithm;
use std::path::PathBuf;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config")
}

fn read(text: &str) -> Result<Vec<Contender>, String> {
    contenders(&Source::new("few.toml", text)).map_err(|error| error.to_string())
}

fn entry(text: &str, settings: &[&str]) -> Result<Scenario, String> {
    let contenders = read(&format!("[[contender]]\nname = \"near\"\n{text}"))?;
    let settings: Vec<Layer> = settings.iter().map(|text| flags::setting(text)).collect::<Result<_, _>>()?;
    refuse_reserved(&settings).map_err(|error| error.to_string())?;
    let entries = Entry::of_all(None, &settings, &contenders).map_err(|error| error.to_string())?;
    entries[0].scenario(5).map_err(|error| error.to_string())
}

#[test]
fn tables_are_laid_over_however_they_are_written() {
    for text in [
        "[contender.look_ahead]\nhorizon_s = 0.5\n[contender.optimizer]\nalgorithm = \"mpio\"\n\
         mpio = { iterations = 5 }",
        "look_ahead.horizon_s = 0.5\noptimizer.algorithm = \"mpio\"\noptimizer.mpio.iterations = 5",
        "look_ahead = { horizon_s = 0.5 }\n[contender.optimizer]\nalgorithm = \"mpio\"\n[contender.optimizer.mpio]\n\
         iterations = 5",
    ] {
        let scenario = entry(text, &["law.formation_gain=0.25", "look_ahead.clearance_m = 2.5"]).unwrap();
        assert_eq!(scenario.controller.look_ahead.horizon_s, 0.5, "{text}");
        assert_eq!(scenario.controller.look_ahead.clearance_m, 2.5);
        assert_eq!(scenario.controller.law.formation_gain, 0.25);
        assert_eq!((scenario.optimizer.algorithm, scenario.optimizer.mpio.iterations), (Algorithm::Mpio, 5));
        assert_eq!((scenario.seed, scenario.starts.len(), scenario.obstacles.len()), (5, 5, 7));
    }
}

#[test]
fn a_contender_has_the_last_word_and_a_preset_the_first() {
    let scenario = entry("look_ahead.horizon_s = 2.0", &["look_ahead.horizon_s=4", "look_ahead.horizon_s=5"]).unwrap();
    assert_eq!(scenario.controller.look_ahead.horizon_s, 2.0);
    let scenario = entry("preset = \"literal\"\nlaw.formation_gain = 0.5", &["preset=paper"]).unwrap();
    let literal = controller::ControllerSettings::literal();
    assert_eq!(scenario.preset, Preset::Literal);
    assert_eq!(scenario.controller.look_ahead, literal.look_ahead);
    assert_eq!(scenario.controller.law, controller::LawSettings { formation_gain: 0.5, ..literal.law });
}

#[test]
fn rows_of_a_list_take_the_place_of_all_rows() {
    let scenario = entry("[[contender.obstacle]]\nx_m = 100\ny_m = 0\nradius_m = 5", &[]).unwrap();
    assert_eq!(scenario.obstacles.len(), 1);
    assert_eq!(scenario.starts.len(), 5);
}

#[test]
fn laying_nothing_over_any_example_changes_nothing() {
    let nothing = Layer::of_flag("--set", "", "").unwrap();
    for name in ["paper.toml", "random12.toml", "hundred.toml"] {
        let ground = Source::read(&folder().join(name), "a scenario").unwrap();
        let (there, _) = tables(&ground, &[]).unwrap();
        let (laid, _) = tables(&ground, &[&nothing]).unwrap();
        assert_eq!(serde_json::to_string(&there).unwrap(), serde_json::to_string(&laid).unwrap(), "{name}");
    }
}

/// Line 3 is the first after the contender's name.
#[test]
fn a_fault_is_told_at_the_contenders_own_line() {
    for (text, settings, told) in [
        (
            "[contender.look_ahead]\nhorizon_s = -1",
            &[][..],
            "few.toml:4: contender \"near\": look_ahead.horizon_s = -1: must be a number greater than 0 and at most 60",
        ),
        (
            "look_ahead.horizn_s = 1",
            &[],
            "few.toml:3: contender \"near\": look_ahead.horizn_s: unknown key: did you mean horizon_s?",
        ),
        (
            "lok_ahead.horizon_s = 1",
            &[],
            "few.toml:3: contender \"near\": lok_ahead: unknown key: did you mean look_ahead?",
        ),
        (
            "optimizer.algorithm = \"nsga\"",
            &[],
            "few.toml:3: contender \"near\": optimizer.algorithm = \"nsga\": must be",
        ),
        ("law = [1]", &[], "few.toml:3: contender \"near\": law: must not be an array"),
        ("law = 1", &[], "few.toml:3: contender \"near\": law = 1: must be a table"),
        (
            "law.safe_distance_m = \"x\"",
            &[],
            "few.toml:3: contender \"near\": law.safe_distance_m = \"x\": must be a number",
        ),
        (
            "dynamics.speed_max_mps = 10.6",
            &[],
            "config/paper.toml (built in):46: with contender \"near\": vehicle[4].speed_mps = 11.0: must be a number \
             from 5 to 10.6",
        ),
        (
            "[[contender.obstacle]]\nx_m = 10\ny_m = 1\nradius_m = 5",
            &[],
            "config/paper.toml (built in):35: with contender \"near\": vehicle 3 at x_m = 10, y_m = 0: must be outside \
             obstacle 1",
        ),
        ("scenario.seed = 2", &[], "few.toml:3: contender \"near\": scenario.seed: must be left out: --seeds says"),
        ("[contender.scenario]\nname = \"x\"", &[], "few.toml:4: contender \"near\": scenario.name: must be left out"),
        ("", &["law.formation_gain=-1"], "--set law.formation_gain=-1: must be a number from 0 to 1000"),
        ("", &["law.gain=1"], "--set law.gain=1: unknown key"),
        ("", &["law.formation_gain=much"], "--set law.formation_gain=much: must be a number"),
        ("", &["scenario.seed=1"], "--set scenario.seed=1: must be left out: --seeds says"),
    ] {
        let refused = entry(text, settings).map(|_| ()).unwrap_err();
        assert!(refused.starts_with(told), "{text} {settings:?}\n{refused}");
    }
}

#[test]
fn every_contender_that_is_none_is_told_by_line() {
    let told = read("[[contender]]\nname = \"a\"\n[[contender]]\nname = \"a\"\n[[contender]]\n[[contender]]\nname = 3")
        .unwrap_err();
    let lines: Vec<&str> = told.lines().collect();
    assert_eq!(lines[0], "few.toml:4: contender[2].name = \"a\": must be no other contender's");
    assert_eq!(lines[1], "few.toml:5: contender[3]: the key name is missing");
    assert!(lines[2].starts_with("few.toml:7: contender[4].name: must be a text in quotes"), "{told}");
    assert_eq!(lines.len(), 3);
    for (text, told) in [
        ("", "few.toml: no contender: must have a table [[contender]] for each, with a name"),
        ("[contender]\nname = \"a\"", "few.toml: no contender"),
        ("\n[law]", "few.toml:2: law: unknown key: a file of contenders has only [[contender]] tables"),
        ("[[contender]\n", "few.toml:1: `[[contender]`"),
    ] {
        let refused = read(text).unwrap_err();
        assert!(refused.starts_with(told), "{text}\n{refused}");
    }
}

#[test]
fn a_setting_has_a_key_and_a_value() {
    for text in ["", "=", "law", "law.formation_gain", "law.formation_gain=", "a b=1", "[law]\na=1", "=1"] {
        assert!(flags::setting(text).unwrap_err().starts_with("must be KEY=VALUE"), "{text}");
    }
    for text in ["preset=paper", "preset = \"paper\"", "law.formation_gain=1e-3", "scenario.origin={latitude_deg=3}"] {
        assert!(flags::setting(text).is_ok(), "{text}");
    }
}
