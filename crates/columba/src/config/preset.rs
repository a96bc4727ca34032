//! Presets: what the law, the weights and the look-ahead start from.

use super::file::{Preset, ScenarioFile};
use super::source::{ConfigError, Source};
use controller::ControllerSettings;
use serde::{Serialize, de::DeserializeOwned};
use toml_edit::{Item, Table};

/// Lets the file's tables change the preset instead of the defaults they were read with.
pub fn apply(file: &mut ScenarioFile, source: &Source) -> Result<(), ConfigError> {
    let base = match file.preset {
        Preset::Default => return Ok(()),
        Preset::Paper => ControllerSettings::paper(),
        Preset::Literal => ControllerSettings::literal(),
    };
    let document = source.document();
    let written =
        |table: &str| document.as_ref().and_then(|document| document.get(table)).and_then(Item::as_table_like);
    file.law = overlay(&base.law, written("law")).unwrap_or(base.law);
    file.weights = overlay(&base.weights, written("weights")).unwrap_or(base.weights);
    file.look_ahead = overlay(&base.look_ahead, written("look_ahead")).unwrap_or(base.look_ahead);
    Ok(())
}

/// `base` with the keys that are written.
fn overlay<T: Serialize + DeserializeOwned>(base: &T, written: Option<&dyn toml_edit::TableLike>) -> Option<T> {
    let mut table: Table = toml_edit::ser::to_document(base).ok()?.as_table().clone();
    for (key, item) in written?.iter() {
        table.insert(key, item.clone());
    }
    toml_edit::de::from_str(&table.to_string()).ok()
}
