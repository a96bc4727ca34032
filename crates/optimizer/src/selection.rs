//! The choice of one member of a front: the decision of Step 7 of Algorithm 1.

use crate::crowding::half_gap;
use crate::optimizer::Front;

/// The member nearest to the ideal point (the front's best value of every objective), by Euclidean distance in costs
/// normalised to the front's range. Of equally near members, the one with the lowest index; 0 for an empty front.
///
/// Members of a front violate equally, so this is a feasible one wherever a feasible candidate was found.
pub fn nearest_to_ideal(front: &Front<'_>) -> usize {
    let mut nearest = (0, f64::INFINITY);
    for member in 0..front.len() {
        let squared_distance = (0..front.objectives())
            .map(|k| {
                let (ideal, range) = (front.ideal()[k], half_gap(front.nadir()[k], front.ideal()[k]));
                let distance = half_gap(front.objective(k)[member], ideal);
                // All members equal: the objective decides nothing.
                if range > 0.0 { (distance / range) * (distance / range) } else { 0.0 }
            })
            .sum();
        if squared_distance < nearest.1 {
            nearest = (member, squared_distance);
        }
    }
    nearest.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimizer::FrontBuffer;

    fn front(costs: &[[f64; 2]]) -> FrontBuffer {
        let mut buffer = FrontBuffer::default();
        buffer.fill(costs.len(), 1, 2, |i, _| i as f64, |i, k| costs[i][k], |_| 0.0);
        buffer
    }

    #[test]
    fn the_knee_is_nearest_whatever_the_units() {
        let costs = [[0.0, 1.0], [0.2, 0.25], [0.6, 0.2], [1.0, 0.0]];
        assert_eq!(nearest_to_ideal(&front(&costs).front()), 1);
        let scaled = costs.map(|[a, b]| [1e6 * a - 3.0, 1e-3 * b]);
        assert_eq!(nearest_to_ideal(&front(&scaled).front()), 1);
    }

    #[test]
    fn ties_go_to_the_lowest_index() {
        assert_eq!(nearest_to_ideal(&front(&[[0.0, 1.0], [1.0, 0.0]]).front()), 0);
        assert_eq!(nearest_to_ideal(&front(&[[3.0, 3.0]]).front()), 0);
        assert_eq!(nearest_to_ideal(&front(&[[3.0, 3.0], [3.0, 3.0]]).front()), 0);
    }

    #[test]
    fn the_greatest_numbers_do_not_overflow() {
        let costs = [[-f64::MAX, f64::MAX], [-0.9 * f64::MAX, -0.9 * f64::MAX], [f64::MAX, -f64::MAX]];
        assert_eq!(nearest_to_ideal(&front(&costs).front()), 1);
    }
}
