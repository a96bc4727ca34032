//! Test problems whose fronts are known: ZDT1-4 and 6 (Zitzler, Deb and Thiele 2000), DTLZ1 and 2 (Deb, Thiele,
//! Laumanns and Zitzler 2005). They measure optimisers, here and in comparisons.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::problem::{Bounds, Candidates, Evaluations, Problem};

/// Which function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suite {
    /// A convex front: f2 = 1 - sqrt(f1).
    Zdt1,
    /// A concave front: f2 = 1 - f1^2.
    Zdt2,
    /// A front of five pieces: f2 = 1 - sqrt(f1) - f1 sin(10 pi f1).
    Zdt3,
    /// The front of ZDT1, beside many local ones.
    Zdt4,
    /// A concave front that is hard to find and sparse towards one end: f2 = 1 - f1^2 with f1 at least 0.2807753191.
    Zdt6,
    /// A linear front, sum f = 1/2, beside many local ones.
    Dtlz1,
    /// The unit sphere, sum f^2 = 1.
    Dtlz2,
}

impl Suite {
    /// All of them.
    pub const ALL: [Self; 7] = [Self::Zdt1, Self::Zdt2, Self::Zdt3, Self::Zdt4, Self::Zdt6, Self::Dtlz1, Self::Dtlz2];

    /// Its name in the literature.
    pub fn name(self) -> &'static str {
        match self {
            Self::Zdt1 => "ZDT1",
            Self::Zdt2 => "ZDT2",
            Self::Zdt3 => "ZDT3",
            Self::Zdt4 => "ZDT4",
            Self::Zdt6 => "ZDT6",
            Self::Dtlz1 => "DTLZ1",
            Self::Dtlz2 => "DTLZ2",
        }
    }

    /// The problem with so many dimensions and objectives. ZDT always has two objectives, and at least two dimensions;
    /// DTLZ has at least two objectives, and at least as many dimensions.
    pub fn problem(self, dimensions: usize, objectives: usize) -> TestProblem {
        let objectives = if self.is_dtlz() { objectives.max(2) } else { 2 };
        let mut bounds = vec![Bounds::new(0.0, 1.0); dimensions.max(objectives)];
        if self == Self::Zdt4 {
            bounds[1..].fill(Bounds::new(-5.0, 5.0));
        }
        TestProblem { suite: self, bounds, objectives, position: Vec::new(), costs: Vec::new() }
    }

    /// The problem with as many dimensions as is customary (ZDT1-3: 30, ZDT4 and 6: 10, DTLZ1: 7, DTLZ2: 12), unless
    /// others are asked for, and with 3 objectives for DTLZ.
    pub fn customary(self, dimensions: Option<usize>) -> TestProblem {
        let customary = match self {
            Self::Zdt1 | Self::Zdt2 | Self::Zdt3 => 30,
            Self::Zdt4 | Self::Zdt6 => 10,
            Self::Dtlz1 => 7,
            Self::Dtlz2 => 12,
        };
        self.problem(dimensions.unwrap_or(customary), 3)
    }

    fn is_dtlz(self) -> bool {
        matches!(self, Self::Dtlz1 | Self::Dtlz2)
    }
}

/// One of the suite as a [`Problem`], without constraints.
#[derive(Clone, Debug)]
pub struct TestProblem {
    suite: Suite,
    bounds: Vec<Bounds>,
    objectives: usize,
    position: Vec<f64>,
    costs: Vec<f64>,
}

impl TestProblem {
    /// Which function it is.
    pub fn suite(&self) -> Suite {
        self.suite
    }

    /// Points of the true front, each with every objective, as IGD+ asks for. Two objectives: `divisions + 1` points
    /// evenly in f1 (on a sphere: in the angle), of which ZDT3 keeps those on the front. More: a simplex lattice of so
    /// many divisions.
    pub fn pareto_front(&self, divisions: usize) -> Vec<Vec<f64>> {
        let divisions = divisions.max(1);
        let along = (0..=divisions).map(|i| i as f64 / divisions as f64);
        match self.suite {
            Suite::Zdt1 | Suite::Zdt4 => along.map(|f1| vec![f1, 1.0 - f1.sqrt()]).collect(),
            Suite::Zdt2 => along.map(|f1| vec![f1, 1.0 - f1 * f1]).collect(),
            Suite::Zdt3 => {
                let mut least = f64::INFINITY;
                let mut front = Vec::new();
                for f1 in along {
                    let f2 = 1.0 - f1.sqrt() - f1 * libm::sin(10.0 * PI * f1);
                    // A point is on the front if its f2 is less than that of all points with a smaller f1.
                    if f2 < least {
                        least = f2;
                        front.push(vec![f1, f2]);
                    }
                }
                front
            }
            Suite::Zdt6 => {
                let least = 0.280_775_319_1;
                along.map(|t| least + (1.0 - least) * t).map(|f1| vec![f1, 1.0 - f1 * f1]).collect()
            }
            Suite::Dtlz1 => lattice(self.objectives, divisions).into_iter().map(|point| scaled(point, 0.5)).collect(),
            Suite::Dtlz2 if self.objectives == 2 => {
                along.map(|t| vec![libm::cos(FRAC_PI_2 * t), libm::sin(FRAC_PI_2 * t)]).collect()
            }
            Suite::Dtlz2 => {
                let onto_sphere = |point: Vec<f64>| {
                    let norm = point.iter().map(|x| x * x).sum::<f64>().sqrt();
                    scaled(point, 1.0 / norm)
                };
                lattice(self.objectives, divisions).into_iter().map(onto_sphere).collect()
            }
        }
    }

    /// The sample of the true front that comparisons measure IGD+ by: 1001 points of two objectives (ZDT3: those on the
    /// front), or 496 of three.
    pub fn reference_front(&self) -> Vec<Vec<f64>> {
        self.pareto_front(if self.objectives == 2 { 1000 } else { 30 })
    }

    /// The point that comparisons measure hypervolume by: in every objective a tenth beyond where the front ends, at 1,
    /// or at 1/2 for DTLZ1. (ZDT3 ends earlier in f1; it has the point of the other ZDT.)
    pub fn reference_point(&self) -> Vec<f64> {
        vec![if self.suite == Suite::Dtlz1 { 0.55 } else { 1.1 }; self.objectives]
    }

    fn judge(suite: Suite, x: &[f64], costs: &mut [f64]) {
        let (f1, rest) = (x[0], &x[1..]);
        let mean = || rest.iter().sum::<f64>() / rest.len() as f64;
        match suite {
            Suite::Zdt1 => {
                let g = 1.0 + 9.0 * mean();
                costs.copy_from_slice(&[f1, g * (1.0 - (f1 / g).sqrt())]);
            }
            Suite::Zdt2 => {
                let g = 1.0 + 9.0 * mean();
                costs.copy_from_slice(&[f1, g * (1.0 - (f1 / g) * (f1 / g))]);
            }
            Suite::Zdt3 => {
                let g = 1.0 + 9.0 * mean();
                costs.copy_from_slice(&[f1, g * (1.0 - (f1 / g).sqrt() - f1 / g * libm::sin(10.0 * PI * f1))]);
            }
            Suite::Zdt4 => {
                let rastrigin = rest.iter().map(|x| x * x - 10.0 * libm::cos(4.0 * PI * x)).sum::<f64>();
                let g = 1.0 + 10.0 * rest.len() as f64 + rastrigin;
                costs.copy_from_slice(&[f1, g * (1.0 - (f1 / g).sqrt())]);
            }
            Suite::Zdt6 => {
                let sine = libm::sin(6.0 * PI * f1);
                let f1 = 1.0 - libm::exp(-4.0 * f1) * sine * sine * sine * sine * sine * sine;
                let g = 1.0 + 9.0 * mean().sqrt().sqrt();
                costs.copy_from_slice(&[f1, g * (1.0 - (f1 / g) * (f1 / g))]);
            }
            Suite::Dtlz1 => {
                let (shape, distance) = x.split_at(costs.len() - 1);
                let rastrigin =
                    distance.iter().map(|x| (x - 0.5) * (x - 0.5) - libm::cos(20.0 * PI * (x - 0.5))).sum::<f64>();
                let g = 100.0 * (distance.len() as f64 + rastrigin);
                // f1 = (1 + g)/2 x1 x2 .. x(M-1), f2 = (1 + g)/2 x1 .. (1 - x(M-1)), .., fM = (1 + g)/2 (1 - x1).
                let mut product = 0.5 * (1.0 + g);
                for (cost, x) in costs.iter_mut().skip(1).rev().zip(shape) {
                    *cost = product * (1.0 - x);
                    product *= x;
                }
                costs[0] = product;
            }
            Suite::Dtlz2 => {
                let (shape, distance) = x.split_at(costs.len() - 1);
                let g = distance.iter().map(|x| (x - 0.5) * (x - 0.5)).sum::<f64>();
                // f1 = (1 + g) cos(x1 pi/2) .. cos(x(M-1) pi/2), .., fM = (1 + g) sin(x1 pi/2).
                let mut product = 1.0 + g;
                for (cost, x) in costs.iter_mut().skip(1).rev().zip(shape) {
                    *cost = product * libm::sin(FRAC_PI_2 * x);
                    product *= libm::cos(FRAC_PI_2 * x);
                }
                costs[0] = product;
            }
        }
    }
}

impl Problem for TestProblem {
    fn bounds(&self) -> &[Bounds] {
        &self.bounds
    }

    fn objectives(&self) -> usize {
        self.objectives
    }

    fn evaluate(&mut self, candidates: &Candidates<'_>, evaluations: &mut Evaluations<'_>) {
        self.costs.resize(self.objectives, 0.0);
        for i in 0..candidates.len() {
            self.position.clear();
            self.position.extend((0..candidates.dimensions()).map(|dimension| candidates.coordinate(dimension)[i]));
            Self::judge(self.suite, &self.position, &mut self.costs);
            for (objective, &cost) in self.costs.iter().enumerate() {
                evaluations.objective(objective)[i] = cost;
            }
        }
    }
}

/// Every point of the unit simplex whose coordinates are multiples of 1 / divisions (Das and Dennis).
fn lattice(objectives: usize, divisions: usize) -> Vec<Vec<f64>> {
    let mut points = vec![(Vec::new(), divisions)];
    for _ in 1..objectives {
        let longer = points
            .into_iter()
            .flat_map(|(point, left)| (0..=left).map(move |part| ([&point[..], &[part]].concat(), left - part)));
        points = longer.collect();
    }
    let whole = |(point, left): (Vec<usize>, usize)| {
        point.into_iter().chain([left]).map(|part| part as f64 / divisions as f64).collect()
    };
    points.into_iter().map(whole).collect()
}

fn scaled(mut point: Vec<f64>, factor: f64) -> Vec<f64> {
    point.iter_mut().for_each(|x| *x *= factor);
    point
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(suite: Suite, x: &[f64], objectives: usize) -> Vec<f64> {
        let mut costs = vec![f64::NAN; objectives];
        suite
            .problem(x.len(), objectives)
            .evaluate(&Candidates::new(x, 1), &mut Evaluations::new(&mut costs, &mut [0.0]));
        costs
    }

    fn assert_near(ours: &[f64], expected: &[f64]) {
        assert_eq!(ours.len(), expected.len());
        assert!(ours.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{ours:?} is not {expected:?}");
    }

    #[test]
    fn values_worked_out_by_hand() {
        // g = 1 + 9 (0.5 + 0.5) / 2 = 5.5.
        assert_near(&judged(Suite::Zdt1, &[0.25, 0.5, 0.5], 2), &[0.25, 5.5 - (0.25_f64 * 5.5).sqrt()]);
        assert_near(&judged(Suite::Zdt2, &[0.25, 0.5, 0.5], 2), &[0.25, 5.5 - 0.0625 / 5.5]);
        // sin(2.5 pi) = 1.
        assert_near(&judged(Suite::Zdt3, &[0.25, 0.5, 0.5], 2), &[0.25, 5.5 - (0.25_f64 * 5.5).sqrt() - 0.25]);
        // g = 1 + 10 + (0.25 - 10 cos(2 pi)) = 1.25.
        assert_near(&judged(Suite::Zdt4, &[0.2, 0.5], 2), &[0.2, 1.25 - 0.5]);
        // sin(6 pi / 12) = 1, g = 1 + 9 (1/16)^(1/4) = 5.5.
        let f1 = 1.0 - libm::exp(-1.0 / 3.0);
        assert_near(&judged(Suite::Zdt6, &[1.0 / 12.0, 0.0625], 2), &[f1, 5.5 - f1 * f1 / 5.5]);
        // cos(20 pi / 4) = -1: g = 100 (1 + 1/16 + 1) = 206.25.
        assert_near(&judged(Suite::Dtlz1, &[0.5, 0.25, 0.75], 3), &[12.953125, 38.859375, 51.8125]);
        // g = 0.0625; the angles are 30 and 60 degrees.
        let (root, g) = (3.0_f64.sqrt(), 1.0625);
        assert_near(&judged(Suite::Dtlz2, &[1.0 / 3.0, 2.0 / 3.0, 0.75], 3), &[g * root / 4.0, g * 0.75, g * 0.5]);
    }

    #[test]
    fn the_best_distance_variables_lie_on_the_front() {
        for suite in Suite::ALL {
            let objectives = if suite.is_dtlz() { 3 } else { 2 };
            for t in [0.08, 0.2, 0.45, 0.6, 0.85] {
                let mut x = vec![if suite.is_dtlz() { 0.5 } else { 0.0 }; 6];
                x[..objectives - 1].fill(t);
                let f = judged(suite, &x, objectives);
                let residual = match suite {
                    Suite::Zdt1 | Suite::Zdt4 => f[1] - (1.0 - f[0].sqrt()),
                    Suite::Zdt2 | Suite::Zdt6 => f[1] - (1.0 - f[0] * f[0]),
                    Suite::Zdt3 => f[1] - (1.0 - f[0].sqrt() - f[0] * libm::sin(10.0 * PI * f[0])),
                    Suite::Dtlz1 => f.iter().sum::<f64>() - 0.5,
                    Suite::Dtlz2 => f.iter().map(|f| f * f).sum::<f64>() - 1.0,
                };
                assert!(residual.abs() < 1e-9, "{}: {f:?}", suite.name());
            }
        }
    }

    #[test]
    fn true_fronts_are_mutually_non_dominated() {
        for suite in Suite::ALL {
            let front = suite.problem(12, 3).pareto_front(20);
            assert!(front.len() >= 5, "{}", suite.name());
            for a in &front {
                assert!(front.iter().all(|b| a == b || a.iter().zip(b).any(|(a, b)| a < b)), "{}", suite.name());
            }
        }
        assert_eq!(Suite::Dtlz1.problem(7, 3).pareto_front(12).len(), 91);
        let zdt3 = Suite::Zdt3.problem(3, 2).pareto_front(10_000);
        // The front's last piece ends where f1 is 0.8518328654 (Zitzler, Deb and Thiele).
        assert!((zdt3[zdt3.len() - 1][0] - 0.851_83).abs() < 2e-4);
    }
}
