//! Presets: what the law, the weights and the look-ahead start from.

use super::file::{Preset, ScenarioFile};
use super::source::{ConfigError, Source};
use controller::ControllerSettings;
use serde::{Serialize, de::DeserializeOwned};
use toml_edit::{DocumentMut, Item};

/// Lets the file's tables change the preset instead of the defaults they were read with.
pub fn apply(file: &mut ScenarioFile, source: &Source) -> Result<(), ConfigError> {
    let base = match file.preset {
        Preset::Default => return Ok(()),
        Preset::Paper => ControllerSettings::paper(),
        Preset::Literal => ControllerSettings::literal(),
    };
    let written = source.written();
    // The tables have been read once already: what is written is right, and only the base beneath it changes.
    let refuse = |error: String| ConfigError::new(vec![format!("{}: {error}", source.name())]);
    file.law = overlay(&base.law, written.get("law")).map_err(refuse)?;
    file.weights = overlay(&base.weights, written.get("weights")).map_err(refuse)?;
    file.look_ahead = overlay(&base.look_ahead, written.get("look_ahead")).map_err(refuse)?;
    Ok(())
}

/// `base` with the keys that are written.
fn overlay<T: Serialize + DeserializeOwned>(base: &T, written: Option<&Item>) -> Result<T, String> {
    let mut document: DocumentMut = toml_edit::ser::to_document(base).map_err(|error| error.to_string())?;
    for (key, item) in written.and_then(Item::as_table_like).into_iter().flat_map(|table| table.iter()) {
        document.insert(key, item.clone());
    }
    toml_edit::de::from_document(document).map_err(|error| error.message().to_owned())
}
