//! What the optimiser of one vehicle had to choose from at a tick, and where each choice would have led: for people,
//! not for the flight, which is the same whether this is asked for or not.

use crate::forecast::Passage;
use crate::look_ahead::{LookAhead, Scene};
use crate::rollout::Rollout;
use optimizer::Front;

/// A front has at most so many members here: beyond that every n-th, and the chosen one.
const MEMBERS_MAX: usize = 60;

/// The Pareto front of one solve, and the predicted flight of each of its members.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Insight {
    /// The optimiser's name.
    pub optimizer: &'static str,
    /// Which tick it is of.
    pub tick: u64,
    /// Members, in order of their first cost; of a long front not all.
    pub members: Vec<Member>,
    /// How many members the front had.
    pub front_len: usize,
    /// Index of the chosen member, the one nearest to the ideal (reading 12).
    pub chosen: usize,
    /// By how many metres the predicted flight falls short of the constraints: the same for all members.
    pub violation_m: f64,
    /// The predicted flight of another command, if all commands together made the vehicle evade.
    pub evasion_path_m: Option<Vec<[f64; 2]>>,
}

/// A choice of weights that no other dominates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Member {
    /// alpha_f, alpha_o and alpha_nv.
    pub weights: [f64; 3],
    /// Eq. 11 and Eq. 12.
    pub costs: [f64; 2],
    /// North and east in m, from the present on at every control period.
    pub path_m: Vec<[f64; 2]>,
}

impl Insight {
    /// Takes a front over; `weights` are those of a member.
    pub fn take(&mut self, front: &Front<'_>, chosen: usize, weights: impl Fn(usize) -> [f64; 3]) {
        let stride = front.len().div_ceil(MEMBERS_MAX).max(1);
        let kept = (0..front.len()).filter(|member| member % stride == 0 || *member == chosen);
        self.members.clear();
        for member in kept {
            if member == chosen {
                self.chosen = self.members.len();
            }
            let costs = [0, 1].map(|objective| front.objective(objective)[member]);
            self.members.push(Member { weights: weights(member), costs, path_m: Vec::new() });
        }
        self.front_len = front.len();
        self.evasion_path_m = None;
        self.violation_m = front.violation().get(chosen).copied().unwrap_or(f64::INFINITY);
    }

    /// There is no front: no prediction was finite.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Flies each member through the scene.
    pub fn fly(&mut self, look_ahead: &LookAhead, scene: &Scene<'_>, rollout: &mut Rollout) {
        let weights: Vec<[f64; 3]> = self.members.iter().map(|member| member.weights).collect();
        let paths = look_ahead.paths_m(scene, &weights, rollout);
        for (member, path_m) in self.members.iter_mut().zip(paths) {
            member.path_m = path_m;
        }
    }

    /// The vehicle evades: the forecast of the command that goes out.
    pub fn evade(&mut self, forecast: &[Passage]) {
        // A forecast has two passages in each control period.
        self.evasion_path_m = Some(forecast.iter().step_by(2).map(|there| [there.x_m, there.y_m]).collect());
    }
}
