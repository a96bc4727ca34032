//! Downhill simplex (Nelder and Mead 1965): a least value without derivatives.

/// The point of the least `cost` near `start`, whose first simplex has edges of `scale`.
pub(super) fn minimise<const N: usize>(
    start: [f64; N],
    scale: [f64; N],
    mut cost: impl FnMut(&[f64; N]) -> f64,
) -> ([f64; N], f64) {
    const STEPS_MAX: usize = 400;
    const SPREAD: f64 = 1e-10;
    let mut simplex: Vec<([f64; N], f64)> = (0..=N)
        .map(|corner| {
            let mut point = start;
            if corner > 0 {
                point[corner - 1] += scale[corner - 1];
            }
            (point, cost(&point))
        })
        .collect();
    for _ in 0..STEPS_MAX {
        simplex.sort_by(|(_, a), (_, b)| a.total_cmp(b));
        let (best, worst) = (simplex[0], simplex[N]);
        if worst.1 - best.1 <= SPREAD * best.1.abs() {
            break;
        }
        let centre: [f64; N] =
            std::array::from_fn(|axis| simplex[..N].iter().map(|(point, _)| point[axis]).sum::<f64>() / N as f64);
        let mut along = |by: f64| {
            let point: [f64; N] = std::array::from_fn(|axis| centre[axis] + by * (worst.0[axis] - centre[axis]));
            (point, cost(&point))
        };
        let reflected = along(-1.0);
        let next = if reflected.1 < best.1 {
            let expanded = along(-2.0);
            if expanded.1 < reflected.1 { expanded } else { reflected }
        } else if reflected.1 < simplex[N - 1].1 {
            reflected
        } else {
            along(if reflected.1 < worst.1 { -0.5 } else { 0.5 })
        };
        if next.1 < worst.1 {
            simplex[N] = next;
        } else {
            for corner in &mut simplex[1..] {
                let point: [f64; N] = std::array::from_fn(|axis| 0.5 * (best.0[axis] + corner.0[axis]));
                *corner = (point, cost(&point));
            }
        }
    }
    simplex.into_iter().min_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap_or((start, f64::INFINITY))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_the_end_of_a_bent_valley() {
        let rosenbrock = |[x, y]: &[f64; 2]| {
            let (one, other) = (1.0 - x, y - x * x);
            one * one + 100.0 * other * other
        };
        let ([x, y], least) = minimise([-1.2, 1.0], [0.5, 0.5], rosenbrock);
        assert!((x - 1.0).abs() < 1e-3 && (y - 1.0).abs() < 1e-3 && least < 1e-6, "{x} {y} {least}");
    }
}
