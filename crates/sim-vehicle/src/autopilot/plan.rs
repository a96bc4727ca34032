//! The plans that a vehicle keeps: a mission, a fence, rally points.

use mavlink_bridge::PlanItem;

/// The plans on board, each as it was uploaded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plans {
    /// The mission; its first item stands for home.
    pub mission: Vec<PlanItem>,
    /// The fence.
    pub fence: Vec<PlanItem>,
    /// The rally points.
    pub rally: Vec<PlanItem>,
}

impl Plans {
    pub(crate) fn take(&mut self, kind: PlanKind) -> Vec<PlanItem> {
        std::mem::take(self.of(kind))
    }

    pub(crate) fn of(&mut self, kind: PlanKind) -> &mut Vec<PlanItem> {
        match kind {
            PlanKind::Mission => &mut self.mission,
            PlanKind::Fence => &mut self.fence,
            PlanKind::Rally => &mut self.rally,
        }
    }
}

/// What a plan is of. Each is uploaded by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PlanKind {
    Mission,
    Fence,
    Rally,
}

impl PlanKind {
    pub const ALL: [Self; 3] = [Self::Mission, Self::Fence, Self::Rally];

    pub fn name(self) -> &'static str {
        match self {
            Self::Mission => "Mission",
            Self::Fence => "Fence",
            Self::Rally => "Rally",
        }
    }
}
