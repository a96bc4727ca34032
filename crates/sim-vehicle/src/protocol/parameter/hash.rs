//! PX4's checksum of all parameters, by which a ground station knows whether those that it has kept are still right
//! (`param_hash_check` of PX4's parameters.cpp).

use crate::parameters::table::Parameter;
use crate::parameters::{Listed, Parameters};

/// The name under which it is asked for.
pub(super) const NAME: &str = "_HASH_CHECK";

/// CRC-32 over name and value of each parameter in the order of their names, without the inversions at both ends. What
/// changes by itself is left out.
pub(super) fn of(parameters: &Parameters) -> u32 {
    let stays = |listed: &Listed| !matches!(listed, Listed::Acting(parameter) if parameter.is_read_only());
    let listed = (0..parameters.count()).filter_map(|index| parameters.at(index)).filter(stays);
    let mut kept: Vec<_> =
        listed.map(|listed| parameters.on_wire(listed, |acting: Parameter| parameters.get(acting))).collect();
    kept.sort_unstable_by_key(|(name, ..)| *name);
    let mut crc = crc32fast::Hasher::new_with_initial(!0);
    for (name, _, value) in kept {
        crc.update(name.as_bytes());
        crc.update(&value.to_le_bytes());
    }
    !crc.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::firmware::Personality;
    use crate::settings::VehicleSettings;

    /// As PX4 has it, bit by bit.
    fn crc32part(bytes: &[u8], crc: u32) -> u32 {
        bytes.iter().fold(crc, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xEDB8_8320 } else { crc >> 1 })
        })
    }

    #[test]
    fn the_stock_parameters_count_and_so_does_a_change() {
        use crate::Vehicle;
        let with = |stock_parameters| {
            let settings = VehicleSettings { personality: Personality::Px4, stock_parameters, ..Default::default() };
            Vehicle::new(settings).unwrap()
        };
        let (mut stock, own) = (with(true), with(false));
        let before = of(&stock.autopilot().parameters);
        assert_ne!(before, of(&own.autopilot().parameters));
        assert_eq!(before, of(&with(true).autopilot().parameters));
        let parameters = &mut stock.autopilot_mut().parameters;
        let Some(Listed::Inert(index)) = parameters.find("FW_P_TC") else { panic!("FW_P_TC") };
        parameters.write_inert(index, 0.5, 9).unwrap();
        assert_ne!(before, of(&stock.autopilot().parameters));
    }

    #[test]
    fn it_is_the_crc_of_px4() {
        let parameters = Parameters::new(&VehicleSettings { personality: Personality::Px4, ..Default::default() });
        let acting = |listed| match listed {
            Listed::Acting(parameter) => Some(parameter),
            Listed::Inert(_) => None,
        };
        let listed = (0..parameters.count()).filter_map(|index| parameters.at(index)).filter_map(acting);
        let mut names: Vec<_> = listed.filter(|one| !one.is_read_only()).collect();
        names.sort_by_key(|one| parameters.name(*one));
        let expected = names.into_iter().fold(0, |crc, one| {
            let value = parameters.to_wire(one, parameters.get(one)).to_bits().to_le_bytes();
            crc32part(&value, crc32part(parameters.name(one).as_bytes(), crc))
        });
        assert_eq!(of(&parameters), expected);
    }
}
