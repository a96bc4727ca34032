//! `[parameters]`: parameter files, values by name, and whether there are those of the real autopilot.

use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use sim_vehicle::ParameterFile;
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

/// The key of [`ParametersTable::files`]. Parameters have names in capitals.
const FILES: &str = "files";
/// The key of [`ParametersTable::stock`].
const STOCK: &str = "stock";

/// The vehicles' parameters at the start.
#[derive(Clone, Debug, Default)]
pub struct ParametersTable {
    /// Parameter files, relative to the scenario's; the last value of a name counts.
    pub files: Vec<PathBuf>,
    /// Whether clients find all parameters of the real autopilot; none: as the ports of the vehicles say.
    pub stock: Option<bool>,
    /// Values by name, which go before those of the files.
    pub values: BTreeMap<String, f64>,
    /// What is in the files, once they have been read.
    pub read: ParameterFile,
}

impl ParametersTable {
    /// Reads files, of which the last value of a name counts.
    ///
    /// # Errors
    /// What is wrong with which file, as one line.
    pub(super) fn read(&mut self, paths: &[PathBuf]) -> Result<(), String> {
        self.read = ParameterFile::read(paths).map_err(|error| error.to_string())?;
        Ok(())
    }
}

impl<'de> Deserialize<'de> for ParametersTable {
    /// By hand: a flattened map would lose the line of a value that is no number.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Table;

        impl<'de> Visitor<'de> for Table {
            type Value = ParametersTable;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table of parameters")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ParametersTable, A::Error> {
                let mut table = ParametersTable::default();
                while let Some(key) = map.next_key::<String>()? {
                    match &key[..] {
                        FILES => table.files = map.next_value()?,
                        STOCK => table.stock = Some(map.next_value()?),
                        _ => {
                            table.values.insert(key, map.next_value()?);
                        }
                    }
                }
                Ok(table)
            }
        }

        deserializer.deserialize_map(Table)
    }
}

impl Serialize for ParametersTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        if !self.files.is_empty() {
            map.serialize_entry(FILES, &self.files)?;
        }
        if let Some(stock) = self.stock {
            map.serialize_entry(STOCK, &stock)?;
        }
        for (name, value) in &self.values {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}
