//! Every constant of the flocking law and its look-ahead, as a setting with the paper's value or our reading as
//! default.

use flight_model::{RangeError, Ranges};
use serde::{Deserialize, Serialize};

/// All settings of the controller.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ControllerSettings {
    /// The six control terms.
    pub law: LawSettings,
    /// The range of the weights that the optimiser chooses.
    pub weights: WeightSettings,
    /// The predicted flight on which a choice of weights is judged.
    pub look_ahead: LookAheadSettings,
}

/// The flocking law (Eq. 4-10) and its costs (Eq. 11-12).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LawSettings {
    /// C_f of Eq. 5, 1/s2.
    pub formation_gain: f64,
    /// C_c of Eq. 6, m3/s2.
    pub collision_gain: f64,
    /// C_o of Eq. 7, 1/s.
    pub obstacle_gain: f64,
    /// C_nv of Eq. 8, 1/s.
    pub neighbour_velocity_gain: f64,
    /// C_ev of Eq. 9, 1/s.
    pub vertical_velocity_gain: f64,
    /// C_eh of Eq. 10, 1/s2.
    pub altitude_gain: f64,
    /// D_c: neighbours within this horizontal distance act (Eq. 5, 8, 12).
    pub communication_distance_m: f64,
    /// D_d: the desired horizontal distance between neighbours (Eq. 5, 12).
    pub desired_distance_m: f64,
    /// D_s: below this horizontal distance the collision term acts (Eq. 6), and separation counts as lost.
    pub safe_distance_m: f64,
    /// Obstacles are perceived up to this distance of their edge.
    pub perception_distance_m: f64,
    /// Which perceived obstacle steers (reading 8).
    pub obstacle_rule: ObstacleRule,
    /// The steering obstacle's radius is inflated by this much (reading 8: 3 m; half of that flies smoother and closer,
    /// and the clearance constraint of the look-ahead is what keeps vehicles off).
    pub obstacle_margin_m: f64,
    /// On which side an obstacle is passed.
    pub side_rule: SideRule,
    /// l of Eq. 12.
    pub influence_factor: f64,
    /// The weight in Eq. 11 of a deviation of 1 m/s from the expected velocity, in metres of progress, while obstacles
    /// are in sight. The paper counts only progress, which is 0 here; then a vehicle that is fast and far to the side
    /// costs no more than one that holds the course.
    pub velocity_cost_s: f64,
    /// The weight in Eq. 11 of a change of the commanded velocity by 1 m/s from one control period to the next, in
    /// metres of progress. The paper has none: a vehicle that zig-zags about its course costs no more than one that
    /// holds it.
    pub command_cost_s: f64,
    /// How altitude is commanded (reading 5).
    pub altitude_law: AltitudeLaw,
    /// Which time constant turns (reading 4).
    pub course_law: CourseLaw,
}

/// Which obstacle gives the desired avoidance course delta of Eq. 7 (reading 8).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleRule {
    /// The nearest detected one that blocks the corridor along the expected course.
    Blocking,
    /// The nearest detected one, whether in the way or not: the letter of Eq. 7.
    Nearest,
}

/// From which course the smaller turn of Eq. 7 is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SideRule {
    /// As `Command` where vehicles have a dead time of course; there changes of the commanded velocity cost something.
    /// Else as `Course`.
    Auto,
    /// The present one: the letter of Eq. 7. Dead ahead of an obstacle the side may change with every command.
    Course,
    /// The one that the last command asks for: a vehicle that turns to one side goes on to do so.
    Command,
}

/// How the altitude setpoint is made (reading 5).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum AltitudeLaw {
    /// As printed where that settles (control periods up to 0.2 s), else the altitude-hold loop's own.
    Auto,
    /// Eq. 2, 9 and 10 as printed.
    Printed,
    /// h_e is the setpoint of the altitude-hold loop, which settles at any control period.
    Hold,
}

/// The time constant of the course line of Eq. 2 (reading 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum CourseLaw {
    /// The greater of tau_V and tau_phi: as printed for vehicles that turn as quickly as the paper's, and enough for
    /// those that turn slowly.
    Auto,
    /// tau_V, as printed.
    Printed,
    /// tau_phi: the lateral acceleration that is flown is the one that is asked for.
    Own,
}

/// The weight factor alpha of Eq. 5, 7, 8 (reading 9).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct WeightSettings {
    /// One alpha for all three terms, or one for each.
    pub kind: WeightKind,
    /// Least alpha. Above zero every term always acts: with an alpha_o of zero a vehicle that has passed its obstacle
    /// keeps its course of that moment (figures in docs/reading.md).
    pub min: f64,
    /// Greatest alpha.
    pub max: f64,
}

/// Whether the terms share one alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WeightKind {
    /// One alpha: the letter of Eq. 5, 7 and 8.
    Shared,
    /// alpha_f, alpha_o and alpha_nv.
    PerTerm,
}

/// The forecast of the neighbours during a look-ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ForecastKind {
    /// Straight on (reading 11: neighbours are extrapolated).
    Straight,
    /// By the flocking law, each with its last weights, which the ground controller knows. The flock then foresees its
    /// own evasions, and keeps separation where extrapolation does not.
    Law,
}

/// The prediction on which constraints and costs are judged (reading 11).
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LookAheadSettings {
    /// Constraints are judged over this much predicted flight, s; never less than one control period.
    pub horizon_s: f64,
    /// The forecast of the neighbours during that time.
    pub forecast: ForecastKind,
    /// Least distance to any neighbour that satisfies the separation constraint, m.
    pub separation_m: f64,
    /// Least distance to any obstacle's edge that satisfies the clearance constraint, m.
    pub clearance_m: f64,
    /// Whether all commands are checked together before they are sent, and commands that lead too near to something are
    /// replaced by evasive ones (beyond the paper; figures in docs/reading.md).
    pub evasion: bool,
    /// Where a position is not known exactly, both constraints want so many standard deviations of it more; 0: none.
    pub margin_sigmas: f64,
    /// At most this many neighbours, the nearest, enter a prediction.
    pub neighbours_max: usize,
}

impl Default for LawSettings {
    fn default() -> Self {
        Self {
            formation_gain: 0.2,
            collision_gain: 1e5,
            obstacle_gain: 2.0,
            neighbour_velocity_gain: 0.2,
            vertical_velocity_gain: 8.0,
            altitude_gain: 20.0,
            communication_distance_m: 10.0,
            desired_distance_m: 10.0,
            safe_distance_m: 2.0,
            perception_distance_m: 120.0,
            obstacle_rule: ObstacleRule::Blocking,
            obstacle_margin_m: 1.5,
            side_rule: SideRule::Auto,
            influence_factor: 1.0,
            velocity_cost_s: 0.25,
            command_cost_s: 0.0,
            altitude_law: AltitudeLaw::Auto,
            course_law: CourseLaw::Auto,
        }
    }
}

impl Default for WeightSettings {
    fn default() -> Self {
        Self { kind: WeightKind::PerTerm, min: 0.2, max: 3.0 }
    }
}

impl Default for LookAheadSettings {
    fn default() -> Self {
        Self {
            horizon_s: 3.0,
            forecast: ForecastKind::Law,
            separation_m: 3.0,
            clearance_m: 1.0,
            evasion: true,
            margin_sigmas: 1.0,
            neighbours_max: 16,
        }
    }
}

impl LawSettings {
    /// Every setting that is out of its range.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        for (name, value, high) in [
            ("formation_gain", self.formation_gain, 1e3),
            ("collision_gain", self.collision_gain, 1e9),
            ("obstacle_gain", self.obstacle_gain, 1e3),
            ("neighbour_velocity_gain", self.neighbour_velocity_gain, 1e3),
            ("vertical_velocity_gain", self.vertical_velocity_gain, 1e3),
            ("altitude_gain", self.altitude_gain, 1e3),
            ("obstacle_margin_m", self.obstacle_margin_m, 100.0),
            ("influence_factor", self.influence_factor, 1e3),
            ("velocity_cost_s", self.velocity_cost_s, 1e3),
            ("command_cost_s", self.command_cost_s, 1e3),
        ] {
            ranges.within(name, value, 0.0, high);
        }
        for (name, value, high) in [
            ("communication_distance_m", self.communication_distance_m, 1e3),
            ("desired_distance_m", self.desired_distance_m, 1e3),
            ("safe_distance_m", self.safe_distance_m, 1e3),
            ("perception_distance_m", self.perception_distance_m, 1e4),
        ] {
            ranges.above(name, value, 0.0, high);
        }
        ranges.errors()
    }
}

impl WeightSettings {
    /// Every setting that is out of its range.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        ranges.within("min", self.min, 0.0, 100.0);
        ranges.above("max", self.max, self.min, 100.0);
        ranges.errors()
    }
}

impl LookAheadSettings {
    /// Longest horizon, s.
    pub const HORIZON_MAX_S: f64 = 60.0;

    /// Every setting that is out of its range.
    pub fn check(&self) -> Vec<RangeError> {
        let mut ranges = Ranges::default();
        ranges.above("horizon_s", self.horizon_s, 0.0, Self::HORIZON_MAX_S);
        ranges.above("separation_m", self.separation_m, 0.0, 1e3);
        ranges.within("clearance_m", self.clearance_m, 0.0, 100.0);
        ranges.within("margin_sigmas", self.margin_sigmas, 0.0, 10.0);
        ranges.whole("neighbours_max", self.neighbours_max, 1, 64);
        ranges.errors()
    }

    /// Control periods in the horizon, at least one.
    pub fn steps(&self, control_period_s: f64) -> usize {
        ((self.horizon_s / control_period_s).round() as usize).max(1)
    }
}

impl ControllerSettings {
    /// The paper with the readings that make it work as described: one alpha for all terms.
    pub fn paper() -> Self {
        let mut settings = Self::default();
        settings.law.obstacle_margin_m = 3.0;
        settings.law.side_rule = SideRule::Course;
        settings.law.velocity_cost_s = 0.0;
        settings.law.command_cost_s = 0.0;
        settings.law.course_law = CourseLaw::Printed;
        settings.weights = WeightSettings { kind: WeightKind::Shared, min: 0.0, ..settings.weights };
        settings.look_ahead.forecast = ForecastKind::Straight;
        settings.look_ahead.evasion = false;
        settings.look_ahead.margin_sigmas = 0.0;
        settings
    }

    /// The letter of the paper: one step ahead, any nearest obstacle steers by its very edge, printed altitude law.
    pub fn literal() -> Self {
        let mut settings = Self::paper();
        settings.law.obstacle_rule = ObstacleRule::Nearest;
        settings.law.obstacle_margin_m = 0.0;
        settings.law.altitude_law = AltitudeLaw::Printed;
        settings.look_ahead.horizon_s = 1e-3;
        settings.look_ahead.separation_m = settings.law.safe_distance_m;
        settings.look_ahead.clearance_m = 0.0;
        settings
    }
}
