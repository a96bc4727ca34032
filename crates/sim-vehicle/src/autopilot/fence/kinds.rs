//! The kinds of fences, and what parameters say of them.

use crate::parameters::Parameters;
use crate::parameters::table::Parameter;

/// A set of kinds of fences, in the bits of FENCE_TYPE.
pub(crate) type Kinds = u8;
pub(crate) const MAX_ALTITUDE: Kinds = 1;
/// Round home.
pub(crate) const CIRCLE: Kinds = 2;
/// What is uploaded: polygons and circles.
pub(crate) const POLYGON: Kinds = 4;
pub(crate) const MIN_ALTITUDE: Kinds = 8;
pub(crate) const ALL: Kinds = 15;

const OPTION_LOCK_MODE: u16 = 1;
const OPTION_UNION: u16 = 2;

/// The kinds that FENCE_TYPE asks for.
pub(super) fn configured(parameters: &Parameters) -> Kinds {
    parameters.get(Parameter::FenceType) as Kinds
}

/// Whether the mode cannot be changed on the way back (FENCE_OPTIONS).
pub(super) fn mode_is_locked(parameters: &Parameters) -> bool {
    parameters.get(Parameter::FenceOptions) as u16 & OPTION_LOCK_MODE != 0
}

/// Whether the inclusions are one union (FENCE_OPTIONS).
pub(super) fn inclusions_are_one(parameters: &Parameters) -> bool {
    parameters.get(Parameter::FenceOptions) as u16 & OPTION_UNION != 0
}

/// The kinds of fences in words, as in "Max Alt and Polygon fences".
pub(super) fn names(kinds: Kinds) -> String {
    const NAMES: [(Kinds, &str); 4] =
        [(MAX_ALTITUDE, "Max Alt"), (CIRCLE, "Circle"), (POLYGON, "Polygon"), (MIN_ALTITUDE, "Min Alt")];
    let named: Vec<&str> = NAMES.into_iter().filter(|(kind, _)| kinds & kind != 0).map(|(_, name)| name).collect();
    match named.as_slice() {
        [] => "fence".into(),
        [one] => format!("{one} fence"),
        [most @ .., last] => format!("{} and {last} fences", most.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_named_as_arduplane_names_them() {
        for (kinds, name) in [
            (POLYGON, "Polygon fence"),
            (MAX_ALTITUDE | POLYGON, "Max Alt and Polygon fences"),
            (ALL, "Max Alt, Circle, Polygon and Min Alt fences"),
        ] {
            assert_eq!(names(kinds), name);
        }
    }
}
