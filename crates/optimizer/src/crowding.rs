//! The crowding distance (Eq. 17): the distance between the two neighbours of a member of a front.

use crate::dominance::ordered_bits;

/// Computes crowding distances. Keeps its buffers.
#[derive(Clone, Debug, Default)]
pub struct Crowding {
    /// Members by their costs in one objective.
    order: Vec<(u64, u32)>,
    distances: Vec<f64>,
}

impl Crowding {
    /// Makes room for fronts of up to `members`, so that they allocate nothing.
    pub fn reserve(&mut self, members: usize) {
        self.order.clear();
        self.order.reserve(members);
        self.distances.clear();
        self.distances.reserve(members);
    }

    /// The crowding distance of every member of one front, where `cost(i, k)` is objective `k` of member `i`.
    ///
    /// Eq. 17, summed over the objectives: the gap between a member's two neighbours, as a fraction of the front's
    /// range. In each objective the first and the last member have an infinite distance (of equal members, the first by
    /// index is first). An objective in which all are equal, or whose range is not finite, adds nothing.
    pub fn distances(&mut self, members: usize, objectives: usize, cost: impl Fn(usize, usize) -> f64) -> &[f64] {
        self.distances.clear();
        self.distances.resize(members, 0.0);
        self.order.clear();
        self.order.extend((0..members as u32).map(|member| (0, member)));
        for k in 0..objectives {
            let cost = |member: u32| cost(member as usize, k);
            self.order.iter_mut().for_each(|(bits, member)| *bits = ordered_bits(cost(*member)));
            // Two objectives order a front in opposite ways: the second order needs no sort.
            if k > 0 {
                self.order.reverse();
                self.order.chunk_by_mut(|a, b| a.0 == b.0).for_each(<[_]>::reverse);
            }
            self.order.sort_unstable();
            let (Some(&(_, first)), Some(&(_, last))) = (self.order.first(), self.order.last()) else { break };
            let range = half_gap(cost(last), cost(first));
            if range > 0.0 && range.is_finite() {
                for neighbours in self.order.windows(3) {
                    self.distances[neighbours[1].1 as usize] +=
                        half_gap(cost(neighbours[2].1), cost(neighbours[0].1)) / range;
                }
            }
            self.distances[first as usize] = f64::INFINITY;
            self.distances[last as usize] = f64::INFINITY;
        }
        &self.distances
    }
}

/// Half of `high - low`, which cannot overflow; in a quotient of two gaps the halves cancel.
pub(crate) fn half_gap(high: f64, low: f64) -> f64 {
    0.5 * high - 0.5 * low
}
