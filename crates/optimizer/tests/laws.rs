//! Laws of dominance, sorting, crowding and the archive, against plain references.

use optimizer::FrontBuffer;
use optimizer::archive::Archive;
use optimizer::crowding::Crowding;
use optimizer::dominance::{Costs, NonDominatedSort};
use optimizer::{Candidates, Front};
use proptest::prelude::*;

/// Some candidates' costs: objectives column after column, and violations. Coarse values make ties and duplicates
/// common.
#[derive(Clone, Debug)]
struct Population {
    objectives: Vec<f64>,
    violation: Vec<f64>,
}

impl Population {
    fn costs(&self) -> Costs<'_> {
        Costs::new(&self.objectives, &self.violation)
    }

    /// The same candidates in another order: candidate `i` is the old `order[i]`.
    fn permuted(&self, order: &[usize]) -> Self {
        let objectives = self.objectives.chunks_exact(order.len()).flat_map(|column| order.iter().map(|&i| column[i]));
        Self { objectives: objectives.collect(), violation: order.iter().map(|&i| self.violation[i]).collect() }
    }
}

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (-3i32..3).prop_map(f64::from),
        1 => Just(-0.0),
        1 => Just(f64::INFINITY),
        4 => -1e3..1e3,
    ]
}

fn violation() -> impl Strategy<Value = f64> {
    prop_oneof![6 => Just(0.0), 1 => Just(-0.0), 2 => (1i32..3).prop_map(f64::from), 1 => Just(f64::INFINITY)]
}

fn population(objectives: std::ops::RangeInclusive<usize>) -> impl Strategy<Value = Population> {
    (1usize..40, objectives).prop_flat_map(|(len, objectives)| {
        let constrained = prop_oneof![prop::collection::vec(violation(), len), Just(vec![0.0; len])];
        (prop::collection::vec(value(), len * objectives), constrained)
            .prop_map(|(objectives, violation)| Population { objectives, violation })
    })
}

/// Eq. 16 under Deb's rule, letter by letter.
fn dominates(costs: &Costs<'_>, a: usize, b: usize) -> bool {
    let (va, vb) = (costs.violation()[a], costs.violation()[b]);
    let pairs: Vec<_> = (0..costs.objectives()).map(|k| (costs.objective(k)[a], costs.objective(k)[b])).collect();
    va < vb || va == vb && pairs.iter().all(|(a, b)| a <= b) && pairs.iter().any(|(a, b)| a < b)
}

/// Peels front after front off, asking everyone about everyone.
fn naive_ranks(costs: &Costs<'_>) -> Vec<u32> {
    let mut ranks = vec![u32::MAX; costs.len()];
    for rank in 0.. {
        let left: Vec<usize> = (0..costs.len()).filter(|&i| ranks[i] == u32::MAX).collect();
        if left.is_empty() {
            break;
        }
        for &i in left.iter().filter(|&&i| !left.iter().any(|&j| dominates(costs, j, i))) {
            ranks[i] = rank;
        }
    }
    ranks
}

fn sorted(costs: &Costs<'_>) -> NonDominatedSort {
    let mut sort = NonDominatedSort::default();
    sort.sort(costs);
    sort
}

fn row(costs: &Costs<'_>, i: usize) -> Vec<f64> {
    (0..costs.objectives()).map(|k| costs.objective(k)[i]).collect()
}

fn front_rows(front: &Front<'_>) -> Vec<Vec<f64>> {
    (0..front.len()).map(|i| (0..front.objectives()).map(|k| front.objective(k)[i]).collect()).collect()
}

/// An archive after every population was offered, in which a candidate's only coordinate is its number.
fn archive_of(offers: &[Population], capacity: usize) -> FrontBuffer {
    let objectives = offers[0].costs().objectives();
    let mut archive = Archive::default();
    archive.clear(1, objectives, capacity, 40);
    for offer in offers {
        let positions: Vec<f64> = (0..offer.violation.len()).map(|i| i as f64).collect();
        let sort = sorted(&offer.costs());
        archive.offer(&Candidates::new(&positions, positions.len()), &offer.costs(), sort.front(0));
    }
    let mut front = FrontBuffer::default();
    archive.write(&mut front);
    front
}

/// Several populations with the same number of objectives.
fn offers() -> impl Strategy<Value = Vec<Population>> {
    (1usize..=4).prop_flat_map(|objectives| prop::collection::vec(population(objectives..=objectives), 1..6))
}

/// All populations as one.
fn joined(offers: &[Population]) -> Population {
    let objectives = offers[0].costs().objectives();
    let column = |k: usize| offers.iter().flat_map(move |offer| offer.costs().objective(k).to_vec());
    Population {
        objectives: (0..objectives).flat_map(column).collect(),
        violation: offers.iter().flat_map(|offer| offer.violation.clone()).collect(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn dominance_is_eq_16_and_a_strict_partial_order(population in population(1..=4)) {
        let costs = population.costs();
        for a in 0..costs.len() {
            prop_assert!(!costs.dominates(a, a));
            for b in 0..costs.len() {
                prop_assert_eq!(costs.dominates(a, b), dominates(&costs, a, b));
                prop_assert!(!(costs.dominates(a, b) && costs.dominates(b, a)));
                for c in 0..costs.len() {
                    prop_assert!(!(costs.dominates(a, b) && costs.dominates(b, c)) || costs.dominates(a, c));
                }
            }
        }
    }

    #[test]
    fn the_fast_sort_gives_the_naive_ranks(population in population(1..=4)) {
        let costs = population.costs();
        let sort = sorted(&costs);
        prop_assert_eq!(sort.ranks(), naive_ranks(&costs));
    }

    #[test]
    fn fronts_hold_everyone_once_in_lexicographic_order(population in population(1..=4)) {
        let costs = population.costs();
        let sort = sorted(&costs);
        let mut seen = vec![false; costs.len()];
        for rank in 0..sort.fronts() {
            let front = sort.front(rank);
            prop_assert!(!front.is_empty());
            for &i in front {
                prop_assert!(!std::mem::replace(&mut seen[i as usize], true));
                prop_assert_eq!(sort.ranks()[i as usize] as usize, rank);
            }
            for pair in front.windows(2) {
                let [a, b] = [pair[0] as usize, pair[1] as usize];
                let (row_a, row_b) = (row(&costs, a), row(&costs, b));
                prop_assert!(row_a < row_b || row_a == row_b && a < b);
            }
        }
        prop_assert!(seen.into_iter().all(|seen| seen));
    }

    #[test]
    fn permuting_a_population_permutes_its_ranks(
        (population, order) in population(1..=4).prop_flat_map(|population| {
            let order: Vec<usize> = (0..population.violation.len()).collect();
            (Just(population), Just(order).prop_shuffle())
        })
    ) {
        let (before, after) = (sorted(&population.costs()), sorted(&population.permuted(&order).costs()));
        let permuted: Vec<u32> = order.iter().map(|&i| before.ranks()[i]).collect();
        prop_assert_eq!(after.ranks(), permuted);
    }

    /// Of equal costs the first offered stays, so only positions may differ.
    #[test]
    fn permuting_an_offer_changes_no_cost_in_the_archive(
        (population, order) in population(1..=4).prop_flat_map(|population| {
            let order: Vec<usize> = (0..population.violation.len()).collect();
            (Just(population), Just(order).prop_shuffle())
        }),
        capacity in prop_oneof![Just(1000), 1usize..12],
    ) {
        let before = archive_of(std::slice::from_ref(&population), capacity);
        let after = archive_of(&[population.permuted(&order)], capacity);
        prop_assert_eq!(front_rows(&before.front()), front_rows(&after.front()));
        prop_assert_eq!(before.front().violation(), after.front().violation());
    }

    #[test]
    fn permuting_a_front_without_ties_permutes_its_crowding(
        (ranks, order) in (1usize..30).prop_flat_map(|len| {
            let places: Vec<usize> = (0..len).collect();
            let column = || Just(places.clone()).prop_shuffle();
            ([column(), column(), column()], column())
        })
    ) {
        let mut crowding = Crowding::default();
        let cost = |i: usize, k: usize| (ranks[k][i] * ranks[k][i]) as f64;
        let before = crowding.distances(order.len(), 3, cost).to_vec();
        let after = crowding.distances(order.len(), 3, |i, k| cost(order[i], k));
        for (i, &old) in order.iter().enumerate() {
            prop_assert_eq!(after[i], before[old]);
        }
    }

    #[test]
    fn crowding_is_eq_17(costs in prop::collection::vec(prop::array::uniform3(-10i32..10), 1..30)) {
        let costs: Vec<[f64; 3]> = costs.into_iter().map(|row| row.map(f64::from)).collect();
        let mut reference = vec![0.0; costs.len()];
        for k in 0..3 {
            let mut order: Vec<usize> = (0..costs.len()).collect();
            order.sort_by(|&a, &b| costs[a][k].total_cmp(&costs[b][k]));
            let (first, last) = (order[0], order[order.len() - 1]);
            for i in 1..order.len() - 1 {
                if costs[last][k] > costs[first][k] {
                    let gap = costs[order[i + 1]][k] - costs[order[i - 1]][k];
                    reference[order[i]] += gap / (costs[last][k] - costs[first][k]);
                }
            }
            reference[first] = f64::INFINITY;
            reference[last] = f64::INFINITY;
        }
        let mut crowding = Crowding::default();
        let distances = crowding.distances(costs.len(), 3, |i, k| costs[i][k]);
        for (distance, reference) in distances.iter().zip(reference) {
            prop_assert!(*distance == reference || (distance - reference).abs() < 1e-12);
        }
    }

    #[test]
    fn an_archive_with_room_is_exactly_the_pareto_front_of_all_it_saw(offers in offers()) {
        let all = joined(&offers);
        let costs = all.costs();
        let mut expected: Vec<Vec<f64>> = (0..costs.len())
            .filter(|&i| costs.violation()[i] < f64::INFINITY)
            .filter(|&i| !(0..costs.len()).any(|j| dominates(&costs, j, i)))
            .map(|i| row(&costs, i))
            .collect();
        expected.sort_by(|a, b| a.partial_cmp(b).expect("not NaN"));
        expected.dedup();
        let archive = archive_of(&offers, 1000);
        prop_assert_eq!(front_rows(&archive.front()), expected);
        let least = costs.violation().iter().copied().fold(f64::INFINITY, f64::min);
        prop_assert!(archive.front().violation().iter().all(|&violation| violation == least));
    }

    #[test]
    fn a_full_archive_keeps_only_the_best_of_what_it_saw_and_every_objectives_best(
        offers in offers(), capacity in 1usize..12,
    ) {
        let (exact, bounded) = (archive_of(&offers, 1000), archive_of(&offers, capacity));
        let (exact, bounded) = (exact.front(), bounded.front());
        prop_assert!(bounded.len() <= capacity.max(2 * bounded.objectives()));
        prop_assert_eq!(bounded.is_empty(), exact.is_empty());
        prop_assert_eq!(bounded.ideal(), exact.ideal());
        let columns: Vec<f64> = (0..bounded.objectives()).flat_map(|k| bounded.objective(k).to_vec()).collect();
        let costs = Costs::new(&columns, bounded.violation());
        for a in 0..bounded.len() {
            let differs = |b: usize| !costs.dominates(a, b) && row(&costs, a) != row(&costs, b);
            prop_assert!((0..bounded.len()).all(|b| a == b || differs(b)));
        }
    }

    #[test]
    fn whoever_dominates_a_member_takes_its_place(offers in offers(), capacity in 1usize..12) {
        let before = archive_of(&offers, capacity);
        prop_assume!(!before.front().is_empty());
        // Better than the first member in everything by a little: it must be in, and the member out.
        let member = front_rows(&before.front())[0].clone();
        prop_assume!(member.iter().all(|cost| cost.is_finite()));
        let better: Vec<f64> = member.iter().map(|cost| cost - 0.5).collect();
        let dominating = Population { objectives: better.clone(), violation: vec![before.front().violation()[0]] };
        let after = archive_of(&[offers, vec![dominating]].concat(), capacity);
        let rows = front_rows(&after.front());
        prop_assert!(rows.contains(&better));
        prop_assert!(!rows.contains(&member));
    }
}

#[test]
fn a_front_without_a_range_is_crowded_nowhere() {
    let mut crowding = Crowding::default();
    assert_eq!(crowding.distances(4, 1, |_, _| 2.0), [f64::INFINITY, 0.0, 0.0, f64::INFINITY]);
    assert_eq!(crowding.distances(3, 1, |_, _| f64::INFINITY), [f64::INFINITY, 0.0, f64::INFINITY]);
    assert_eq!(crowding.distances(1, 2, |_, _| 2.0), [f64::INFINITY]);
    assert!(crowding.distances(0, 2, |_, _| 2.0).is_empty());
    let extreme = [-f64::MAX, 0.0, f64::MAX];
    assert_eq!(crowding.distances(3, 1, |i, _| extreme[i])[1], 1.0);
}

#[test]
fn an_empty_population_has_no_fronts() {
    assert_eq!(sorted(&Costs::new(&[], &[])).fronts(), 0);
}

#[test]
fn of_equal_costs_the_first_offered_stays() {
    let population = Population { objectives: vec![1.0, 1.0, 2.0, 2.0], violation: vec![0.0; 2] };
    let archive = archive_of(&[population.clone(), population], 10);
    assert_eq!(archive.front().len(), 1);
    assert_eq!(archive.front().position(0, 0), 0.0);
}
