//! Vehicles with an airframe of their own: `airframe` in `[[vehicle]]`, and `[[airframes]]` for ranges of vehicles.

use super::airframe::AirframeKey;
use super::file::ScenarioFile;
use super::provenance::Provenance;
use flight_model::Airframe;

/// The airframe of each vehicle that has one of its own; empty where none has. A later table stands over an earlier
/// one, and that of `[[vehicle]]` over both.
///
/// # Errors
/// Every table that is wrong, by its place and in words.
pub(super) fn airframes(file: &ScenarioFile, provenance: &Provenance) -> Result<Vec<Option<Airframe>>, Vec<String>> {
    let mut own: Vec<Option<Airframe>> = Vec::new();
    let mut wrong = Vec::new();
    let personality = file.autopilot.personality;
    let mut set = |at: String, key: &AirframeKey, folder: &str, vehicles: Result<Vec<usize>, String>| {
        let resolved = key.resolve(&provenance.folder(folder), personality);
        match vehicles.and_then(|vehicles| resolved.map(|airframe| (vehicles, airframe))) {
            Ok((vehicles, airframe)) => {
                own.resize(file.count(), None);
                vehicles.into_iter().filter_map(|index| own.get_mut(index).map(|of| *of = Some(airframe))).count();
            }
            Err(what) => wrong.push(format!("{at}: {what}")),
        }
    };
    for (number, table) in (1..).zip(&file.airframes) {
        let vehicles = indices(&table.vehicles, file.count());
        set(format!("airframes[{number}]"), &table.airframe, "airframes", vehicles);
    }
    for (index, vehicle) in file.vehicle.iter().enumerate() {
        if let Some(key) = &vehicle.airframe {
            set(format!("vehicle[{}].airframe", index + 1), key, "vehicle", Ok(vec![index]));
        }
    }
    if wrong.is_empty() { Ok(own) } else { Err(wrong) }
}

/// The vehicles that a text names by their numbers, as indices.
fn indices(text: &str, count: usize) -> Result<Vec<usize>, String> {
    let wanted = || format!("vehicles = {text:?}: must be numbers and ranges from 1 to {count}, such as \"1-3, 5\"");
    let number = |part: &str| part.trim().parse::<usize>().ok().filter(|number| (1..=count).contains(number));
    let mut vehicles = Vec::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (Some(first), Some(last)) = (number(first), number(last)) else { return Err(wanted()) };
        if first > last {
            return Err(wanted());
        }
        vehicles.extend(first - 1..last);
    }
    Ok(vehicles)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vehicles_are_named_by_numbers_and_ranges() {
        assert_eq!(indices("1-3, 5", 5), Ok(vec![0, 1, 2, 4]));
        for wrong in ["", "0", "6", "3-2", "a", "1-", "1;2"] {
            assert!(indices(wrong, 5).unwrap_err().contains("from 1 to 5"), "{wrong}");
        }
    }
}
