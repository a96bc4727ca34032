//! A fence by ArduPilot's older protocol (FENCE_POINT, AC_PolyFence_loader.cpp): a polygon to stay in and a return
//! point, written point by point. Point 0 is the return point, the last one the first corner again; FENCE_TOTAL is how
//! many there are.

use super::Fence;
use super::items::{POLYGON_INCLUSION, RETURN_POINT};
use flight_model::LocalFrame;
use mavlink_bridge::{FencePoint, LatLonE7, PlanItem};

/// Fewest points of such a fence: the return point, three corners, the first corner again.
const POINTS_MIN: u8 = 5;

/// Why a point is neither taken nor given, in ArduPilot's words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum FencePointError {
    #[error("Vehicle contains advanced fences")]
    Advanced,
    #[error("Invalid FENCE_TOTAL")]
    Total,
    #[error("Invalid fence point, bad count ({got} vs {total})")]
    Count { got: u8, total: u8 },
    #[error("Invalid fence point, index past total ({index} >= {total})")]
    Index { index: u8, total: u8 },
    /// Of one that is asked for: in ArduPilot without the space.
    #[error("Invalid fence point, index past total({index} >= {total})")]
    FetchIndex { index: u8, total: u8 },
    #[error("Invalid fence point, bad lat or lng")]
    Position,
}

impl Fence {
    /// FENCE_TOTAL is set: 0 clears the fence, if that is another number.
    pub fn set_total(&mut self, total: u8) {
        if total == 0 && self.total != 0 {
            *self = Self::default();
        }
        self.total = total;
    }

    /// Takes a point. A fence that this protocol cannot tell is replaced. A polygon counts from its third corner on:
    /// the number of corners is given if it has fewer.
    pub fn set_point(&mut self, point: &FencePoint, frame: &LocalFrame) -> Result<Option<u8>, FencePointError> {
        let FencePoint { index, count, latitude_deg, longitude_deg } = *point;
        self.check_total()?;
        if count != self.total {
            return Err(FencePointError::Count { got: count, total: self.total });
        }
        if index >= self.total {
            return Err(FencePointError::Index { index, total: self.total });
        }
        let is_place = latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0;
        if !is_place {
            return Err(FencePointError::Position);
        }
        let (mut return_point, mut corners) = self.simple().unwrap_or_default();
        // In single precision, as ArduPilot counts it.
        let place = LatLonE7 { latitude_e7: (latitude_deg * 1e7) as i32, longitude_e7: (longitude_deg * 1e7) as i32 };
        if index == 0 {
            return_point = Some(place);
        } else if index == self.total - 1 {
            corners.resize(usize::from(index) - 1, NOWHERE);
        } else {
            let at = usize::from(index) - 1;
            corners.resize(corners.len().max(at + 1), NOWHERE);
            corners[at] = place;
        }
        Ok(self.make(return_point, &corners, frame))
    }

    /// The place of a point, for FENCE_FETCH_POINT; none for one that is not there.
    pub fn point(&self, index: u8) -> Result<FencePoint, FencePointError> {
        let (return_point, corners) = self.simple().ok_or(FencePointError::Advanced)?;
        self.check_total()?;
        if index >= self.total {
            return Err(FencePointError::FetchIndex { index, total: self.total });
        }
        let place = match usize::from(index) {
            0 => return_point.or_else(|| middle(&corners)),
            _ if index == self.total - 1 => corners.first().copied(),
            after => corners.get(after - 1).copied(),
        };
        let place = place.unwrap_or(NOWHERE);
        let [latitude_deg, longitude_deg] = [place.latitude_e7, place.longitude_e7].map(|e7| e7 as f32 * 1e-7);
        Ok(FencePoint { index, count: self.total, latitude_deg, longitude_deg })
    }

    /// Whether there is a place that a breach leads to.
    pub fn has_return_point(&self) -> bool {
        self.simple().is_some_and(|(return_point, corners)| return_point.is_some() || !corners.is_empty())
    }

    fn check_total(&self) -> Result<(), FencePointError> {
        if (1..POINTS_MIN).contains(&self.total) { Err(FencePointError::Total) } else { Ok(()) }
    }

    /// The return point and the corners, if the fence is no more than that.
    fn simple(&self) -> Option<(Option<LatLonE7>, Vec<LatLonE7>)> {
        let of = |command: u16| self.items.iter().filter(move |item| item.command == command);
        let (points, corners) = (of(RETURN_POINT), of(POLYGON_INCLUSION));
        let first = of(POLYGON_INCLUSION).next();
        let is_one = first.is_none_or(|first| usize::from(first.params[0] as u16) == corners.clone().count());
        let is_all = points.clone().count() + corners.clone().count() == self.items.len();
        (is_one && is_all).then(|| (points.map(PlanItem::position).next(), corners.map(PlanItem::position).collect()))
    }

    /// The fence of a return point and corners, as it is told by plans: the return point first.
    fn make(&mut self, return_point: Option<LatLonE7>, corners: &[LatLonE7], frame: &LocalFrame) -> Option<u8> {
        let count = corners.len() as f32;
        let corners = corners.iter().map(|place| item(POLYGON_INCLUSION, count, *place));
        self.items = return_point.map(|place| item(RETURN_POINT, 0.0, place)).into_iter().chain(corners).collect();
        let area = super::items::area(&self.items, frame);
        let is_whole = area.is_ok();
        // What is not whole does not count.
        self.area = area.unwrap_or_default();
        (!is_whole).then_some(count as u8)
    }
}

/// A corner that has not come yet.
const NOWHERE: LatLonE7 = LatLonE7 { latitude_e7: 0, longitude_e7: 0 };

fn item(command: u16, p1: f32, place: LatLonE7) -> PlanItem {
    let LatLonE7 { latitude_e7, longitude_e7 } = place;
    PlanItem { command, latitude_e7, longitude_e7, params: [p1, 0.0, 0.0, 0.0], ..PlanItem::default() }
}

/// The middle of the box round corners, halved before it is added up, as in ArduPilot.
fn middle(corners: &[LatLonE7]) -> Option<LatLonE7> {
    let half = |e7: fn(&LatLonE7) -> i32| {
        let (least, most) = (corners.iter().map(e7).min()?, corners.iter().map(e7).max()?);
        Some(least / 2 + most / 2)
    };
    Some(LatLonE7 {
        latitude_e7: half(|corner| corner.latitude_e7)?,
        longitude_e7: half(|corner| corner.longitude_e7)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::VehicleSettings;
    use flight_model::State;

    fn point(index: u8, count: u8, latitude_deg: f32, longitude_deg: f32) -> FencePoint {
        FencePoint { index, count, latitude_deg, longitude_deg }
    }

    /// A triangle and a return point, in the order of the wire.
    const POINTS: [(f32, f32); 5] = [(1.0, 2.0), (0.0, 1.0), (3.0, 1.0), (2.0, 4.0), (0.0, 1.0)];

    fn written() -> (Fence, Vec<Option<u8>>) {
        let (mut fence, frame) = (Fence::default(), VehicleSettings::default().frame);
        fence.set_total(5);
        let said = (0..).zip(POINTS).map(|(index, (x, y))| fence.set_point(&point(index, 5, x, y), &frame).unwrap());
        let said = said.collect();
        (fence, said)
    }

    #[test]
    fn a_fence_is_written_point_by_point_and_read_again() {
        let (fence, said) = written();
        assert_eq!(said, [None, Some(1), Some(2), None, None]);
        assert_eq!(fence.items().iter().map(|item| item.params[0]).collect::<Vec<_>>(), [0.0, 3.0, 3.0, 3.0]);
        for (index, (x, y)) in (0..).zip(POINTS) {
            let read = fence.point(index).unwrap();
            assert!((read.latitude_deg - x).abs() < 1e-6 && (read.longitude_deg - y).abs() < 1e-6, "{read:?}");
        }
        let outside = State { x_m: 1e6, ..State::default() };
        assert!(fence.area.forbids(outside.position_m(), false));
    }

    #[test]
    fn refusals_are_arduplanes() {
        let (mut fence, frame) = (written().0, VehicleSettings::default().frame);
        let mut refused = |given| fence.set_point(&given, &frame).unwrap_err().to_string();
        assert_eq!(refused(point(1, 6, 0.0, 0.0)), "Invalid fence point, bad count (6 vs 5)");
        assert_eq!(refused(point(5, 5, 0.0, 0.0)), "Invalid fence point, index past total (5 >= 5)");
        assert_eq!(refused(point(1, 5, 91.0, 0.0)), "Invalid fence point, bad lat or lng");
        assert_eq!(refused(point(1, 5, 0.0, f32::NAN)), "Invalid fence point, bad lat or lng");
        fence.set_total(4);
        assert_eq!(fence.point(1), Err(FencePointError::Total));
    }

    #[test]
    fn a_total_of_zero_clears_and_a_fence_of_more_is_replaced() {
        let (mut fence, frame) = (written().0, VehicleSettings::default().frame);
        fence.set_total(0);
        assert!(fence.items().is_empty() && !fence.has_return_point());
        let circle = PlanItem { command: 5003, params: [50.0, 0.0, 0.0, 0.0], ..PlanItem::default() };
        fence.replace(&[circle], &frame).unwrap();
        fence.set_total(5);
        assert_eq!(fence.point(0), Err(FencePointError::Advanced));
        assert_eq!(fence.set_point(&point(0, 5, 1.0, 1.0), &frame), Ok(None));
        assert_eq!(fence.items().iter().map(|item| item.command).collect::<Vec<_>>(), [RETURN_POINT]);
    }

    #[test]
    fn without_a_return_point_it_is_the_middle() {
        let (mut fence, frame) = (Fence::default(), VehicleSettings::default().frame);
        fence.set_total(5);
        for (index, (x, y)) in (0..).zip(POINTS).skip(1) {
            fence.set_point(&point(index, 5, x, y), &frame).unwrap();
        }
        let read = fence.point(0).unwrap();
        assert!((read.latitude_deg - 1.5).abs() < 1e-6 && (read.longitude_deg - 2.5).abs() < 1e-6, "{read:?}");
    }
}
