//! Quality indicators of a front: hypervolume and IGD+. Every objective is minimised; a point is a row with one value
//! per objective.

use crate::optimizer::Front;

/// Why an indicator cannot be computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum IndicatorError {
    /// A point is longer or shorter than the reference.
    #[error("a point of {found} objectives was given where there are {expected}")]
    Objectives {
        /// Of the reference.
        expected: usize,
        /// Of the point.
        found: usize,
    },
    /// A value is NaN or infinite.
    #[error("a value is not a finite number")]
    NotFinite,
    /// There are no points, or no points of the true front.
    #[error("there are no points")]
    Empty,
}

/// The costs of a front's members, one row each.
pub fn rows(front: &Front<'_>) -> Vec<Vec<f64>> {
    (0..front.len()).map(|i| (0..front.objectives()).map(|k| front.objective(k)[i]).collect()).collect()
}

/// The volume that some points dominate inside the box below a reference point (Zitzler and Thiele 1998), exactly.
///
/// Points may be dominated or equal; a point that is not better than the reference in every objective adds nothing. Two
/// objectives are swept in O(n log n), more are the WFG algorithm of While, Bradstreet and Barone (2012): exponential
/// in the objectives.
///
/// # Errors
/// A point or the reference is not finite, or is of another number of objectives. No points dominate a volume of 0.
pub fn hypervolume<P: AsRef<[f64]>>(points: &[P], reference: &[f64]) -> Result<f64, IndicatorError> {
    if reference.is_empty() {
        return Err(IndicatorError::Empty);
    }
    check(points, reference.len())?;
    check(&[reference], reference.len())?;
    let inside = |point: &&[f64]| point.iter().zip(reference).all(|(value, limit)| value < limit);
    let mut points: Vec<Vec<f64>> = points.iter().map(AsRef::as_ref).filter(inside).map(<[f64]>::to_vec).collect();
    // Worst last objective first: limit sets shrink soonest so.
    points.sort_by(|a, b| b.iter().rev().partial_cmp(a.iter().rev()).unwrap_or(std::cmp::Ordering::Equal));
    Ok(volume(points, reference))
}

/// The modified inverted generational distance IGD+ (Ishibuchi, Masuda, Tanigaki and Nojima 2015): the mean over the
/// points z of the true front of the least d+(a, z) over the members a of a front, where
/// d+(a, z) = sqrt(sum_k max(a_k - z_k, 0)^2): only the amount by which a member is worse counts.
///
/// # Errors
/// Either set is empty, a value is not finite, or points are of different numbers of objectives.
pub fn igd_plus<P: AsRef<[f64]>, Q: AsRef<[f64]>>(points: &[P], true_front: &[Q]) -> Result<f64, IndicatorError> {
    let (Some(first), false) = (true_front.first(), points.is_empty()) else { return Err(IndicatorError::Empty) };
    let objectives = first.as_ref().len();
    check(points, objectives)?;
    check(true_front, objectives)?;
    let lack = |a: f64, z: f64| (a - z).max(0.0) * (a - z).max(0.0);
    let distance = |a: &[f64], z: &[f64]| a.iter().zip(z).map(|(&a, &z)| lack(a, z)).sum::<f64>().sqrt();
    let nearest = |z: &Q| points.iter().map(|a| distance(a.as_ref(), z.as_ref())).fold(f64::INFINITY, f64::min);
    Ok(true_front.iter().map(nearest).sum::<f64>() / true_front.len() as f64)
}

fn check<P: AsRef<[f64]>>(points: &[P], objectives: usize) -> Result<(), IndicatorError> {
    for point in points.iter().map(AsRef::as_ref) {
        if point.len() != objectives {
            return Err(IndicatorError::Objectives { expected: objectives, found: point.len() });
        }
        if !point.iter().all(|value| value.is_finite()) {
            return Err(IndicatorError::NotFinite);
        }
    }
    Ok(())
}

/// Each point's inclusive volume, less what the points after it dominate of it.
fn volume(points: Vec<Vec<f64>>, reference: &[f64]) -> f64 {
    if reference.len() <= 2 {
        return sweep(points, reference);
    }
    let exclusive = |(i, point): (usize, &Vec<f64>)| {
        let inclusive: f64 = point.iter().zip(reference).map(|(value, limit)| limit - value).product();
        let limited = points[i + 1..].iter().map(|other| point.iter().zip(other).map(|(a, b)| a.max(*b)).collect());
        inclusive - volume(non_dominated(limited.collect()), reference)
    };
    // Not sum(), which makes -0 of nothing.
    points.iter().enumerate().map(exclusive).fold(0.0, |sum, volume| sum + volume)
}

/// One of equals stays.
fn non_dominated(points: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let mut kept: Vec<Vec<f64>> = Vec::with_capacity(points.len());
    let covers = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a <= b);
    for point in points {
        if !kept.iter().any(|other| covers(other, &point)) {
            kept.retain(|other| !covers(&point, other));
            kept.push(point);
        }
    }
    kept
}

/// One or two objectives: steps from left to right.
fn sweep(mut points: Vec<Vec<f64>>, reference: &[f64]) -> f64 {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let Some(&top) = reference.get(1) else {
        return points.first().map_or(0.0, |point| reference[0] - point[0]);
    };
    let (mut area, mut height) = (0.0, top);
    for point in points {
        if point[1] < height {
            area += (reference[0] - point[0]) * (height - point[1]);
            height = point[1];
        }
    }
    area
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn known_volumes() {
        assert_eq!(hypervolume(&[[1.0]; 2], &[3.0]), Ok(2.0));
        assert_eq!(hypervolume(&[[0.0, 2.0], [1.0, 1.0], [2.0, 0.0]], &[3.0, 3.0]), Ok(6.0));
        assert_eq!(hypervolume(&[[1.0, 1.0], [2.0, 2.0], [1.0, 1.0], [0.0, 3.0]], &[3.0, 3.0]), Ok(4.0));
        // Two cuboids of 2 that share a cube of 1.
        assert_eq!(hypervolume(&[[0.0, 1.0, 1.0], [1.0, 0.0, 1.0]], &[2.0; 3]), Ok(3.0));
        // Three slabs of 4 of a cube of 8, which meet in pairs in 2 and all in 1: 12 - 6 + 1.
        assert_eq!(hypervolume(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], &[2.0; 3]), Ok(7.0));
        // Of four dimensions all but the one cell that is worst in everything: 16 - 1.
        let slabs: Vec<[f64; 4]> = (0..4).map(|k| std::array::from_fn(|d| f64::from(u8::from(d == k)))).collect();
        assert_eq!(hypervolume(&slabs, &[2.0; 4]), Ok(15.0));
        assert_eq!(hypervolume::<[f64; 2]>(&[], &[3.0, 3.0]), Ok(0.0));
    }

    #[test]
    fn a_fine_front_of_zdt1_dominates_two_thirds_of_the_unit_square() {
        let front = crate::suites::Suite::Zdt1.problem(3, 2).pareto_front(100_000);
        assert!((hypervolume(&front, &[1.0, 1.0]).expect("finite") - 2.0 / 3.0).abs() < 2e-5);
    }

    #[test]
    fn only_what_is_lacking_is_a_distance() {
        let front = [[0.0, 1.0], [1.0, 0.0]];
        assert_eq!(igd_plus(&front, &front), Ok(0.0));
        assert_eq!(igd_plus(&[[-1.0, -1.0]], &front), Ok(0.0));
        assert_eq!(igd_plus(&[[3.0, 4.0]], &[[0.0, 0.0]]), Ok(5.0));
        // (0.5, 0.5) lacks 0.5 of each; the distance would be sqrt(0.5).
        assert_eq!(igd_plus(&[[0.5, 0.5]], &front), Ok(0.5));
    }

    #[test]
    fn what_cannot_be_measured_is_refused() {
        assert_eq!(hypervolume(&[[f64::NAN, 0.0]], &[1.0, 1.0]), Err(IndicatorError::NotFinite));
        assert_eq!(hypervolume(&[[0.0, 0.0]], &[1.0, f64::INFINITY]), Err(IndicatorError::NotFinite));
        assert_eq!(hypervolume(&[[0.0]], &[1.0, 1.0]), Err(IndicatorError::Objectives { expected: 2, found: 1 }));
        assert_eq!(hypervolume(&[[0.0; 0]], &[]), Err(IndicatorError::Empty));
        assert_eq!(igd_plus::<[f64; 1], _>(&[], &[[0.0]]), Err(IndicatorError::Empty));
        assert_eq!(igd_plus::<_, [f64; 1]>(&[[0.0]], &[]), Err(IndicatorError::Empty));
        assert_eq!(igd_plus(&[[0.0, 1.0]], &[[0.0]]), Err(IndicatorError::Objectives { expected: 1, found: 2 }));
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// On a grid, the volume is the number of cells that some point dominates.
        #[test]
        fn hypervolume_counts_cells(
            points in (1usize..=4).prop_flat_map(|k| prop::collection::vec(prop::collection::vec(0u8..6, k), 1..9))
        ) {
            let objectives = points[0].len();
            let cells = (0..4_usize.pow(objectives as u32)).filter(|cell| {
                let corner = |k: usize| (cell / 4_usize.pow(k as u32) % 4) as u8;
                points.iter().any(|point| (0..objectives).all(|k| point[k] <= corner(k)))
            });
            let row = |point: &Vec<u8>| point.iter().map(|&x| f64::from(x)).collect();
            let rows: Vec<Vec<f64>> = points.iter().map(row).collect();
            prop_assert_eq!(hypervolume(&rows, &vec![4.0; objectives]), Ok(cells.count() as f64));
        }
    }
}
