//! Open Drone ID, as a PX4 tells it (`streams/OPEN_DRONE_ID_*.hpp`): who flies, where, and from where.

use super::Instruments;
use mavlink_bridge::LatLonE7;
use mavlink_bridge::dialect::{
    MavOdidHorAcc, MavOdidIdType, MavOdidSpeedAcc, MavOdidStatus, MavOdidUaType, MavOdidVerAcc, Message,
    OPEN_DRONE_ID_BASIC_ID_DATA, OPEN_DRONE_ID_LOCATION_DATA, OPEN_DRONE_ID_SYSTEM_DATA,
};

/// An altitude that is not known, m.
const UNKNOWN_M: f32 = -1000.0;
/// A time that is not known, s after the hour.
const UNKNOWN_S: f32 = 65_535.0;

impl Instruments<'_> {
    /// Its serial number: its system id.
    pub(super) fn drone_id_basic(&self) -> Message {
        let mut uas_id = [0; 20];
        let digits = format!("{:019}", self.system_id);
        uas_id.iter_mut().zip(digits.bytes()).for_each(|(field, digit)| *field = digit);
        Message::OPEN_DRONE_ID_BASIC_ID(OPEN_DRONE_ID_BASIC_ID_DATA {
            id_type: MavOdidIdType::MAV_ODID_ID_TYPE_SERIAL_NUMBER,
            ua_type: MavOdidUaType::MAV_ODID_UA_TYPE_AEROPLANE,
            uas_id,
            ..OPEN_DRONE_ID_BASIC_ID_DATA::DEFAULT
        })
    }

    pub(super) fn drone_id_location(&self) -> Message {
        let state = self.flight.estimate();
        let place = self.place();
        let LatLonE7 { latitude_e7, longitude_e7 } = LatLonE7::from_geodetic(&place);
        let status = if self.flight.is_flying() {
            MavOdidStatus::MAV_ODID_STATUS_AIRBORNE
        } else {
            MavOdidStatus::MAV_ODID_STATUS_GROUND
        };
        Message::OPEN_DRONE_ID_LOCATION(OPEN_DRONE_ID_LOCATION_DATA {
            latitude: latitude_e7,
            longitude: longitude_e7,
            altitude_barometric: place.altitude_amsl_m as f32,
            altitude_geodetic: place.altitude_amsl_m as f32,
            height: (state.altitude_m - self.flight.home().altitude_m) as f32,
            timestamp: UNKNOWN_S,
            direction: (1e2 * state.course_rad.to_degrees().rem_euclid(360.0)).round() as u16,
            speed_horizontal: (1e2 * state.speed_mps).round() as u16,
            speed_vertical: (1e2 * state.climb_mps).round() as i16,
            status,
            horizontal_accuracy: MavOdidHorAcc::MAV_ODID_HOR_ACC_1_METER,
            vertical_accuracy: MavOdidVerAcc::MAV_ODID_VER_ACC_3_METER,
            speed_accuracy: MavOdidSpeedAcc::MAV_ODID_SPEED_ACC_1_METERS_PER_SECOND,
            ..OPEN_DRONE_ID_LOCATION_DATA::DEFAULT
        })
    }

    /// Its operator is where it took off.
    pub(super) fn drone_id_system(&self) -> Message {
        let home = self.flight.home();
        let place = self.frame.to_geodetic(home.x_m, home.y_m, home.altitude_m);
        let LatLonE7 { latitude_e7, longitude_e7 } = LatLonE7::from_geodetic(&place);
        Message::OPEN_DRONE_ID_SYSTEM(OPEN_DRONE_ID_SYSTEM_DATA {
            operator_latitude: latitude_e7,
            operator_longitude: longitude_e7,
            area_ceiling: UNKNOWN_M,
            area_floor: UNKNOWN_M,
            operator_altitude_geo: place.altitude_amsl_m as f32,
            area_count: 1,
            ..OPEN_DRONE_ID_SYSTEM_DATA::DEFAULT
        })
    }
}
