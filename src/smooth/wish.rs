//! By how much a line is to turn at a crossing: as its profile says, and as tether and barrier pull.

use super::{
    layout::Layout,
    strip::{Strip, UNKNOWN},
    task::barrier,
    tree::LineTree,
};

/// What is wished of a strip that is laid flat, at the places where its crossings are now.
pub(crate) struct Wish<'a> {
    pub(crate) layout: &'a Layout,
    /// Wished turns; empty: none.
    pub(crate) turns: &'a [f64],
    /// The drawn line and how stiff its tether is at each stretch.
    pub(crate) tether: Option<(&'a LineTree, &'a [f64])>,
    /// Reach of the barrier, and which ends of sides lie on the boundary (right, left).
    pub(crate) barrier: Option<(f64, &'a [[bool; 2]])>,
}

impl Wish<'_> {
    /// The turn at crossing `i`, to the left. Worked out when asked: what solving left behind is not of this strip everywhere.
    pub(crate) fn turn(&self, strip: &Strip, i: usize) -> f64 {
        let own = self.turns.get(i).copied().unwrap_or(0.0);
        let pull = self.pull(strip, i);
        if pull == 0.0 { own } else { own + 2.0 * (0.5 * pull).clamp(-1.0, 1.0).asin() }
    }

    /// What pulls a crossing to the right.
    fn pull(&self, strip: &Strip, i: usize) -> f64 {
        let (layout, at) = (self.layout, strip.at[i]);
        let length = layout.lengths[i];
        if length <= 0.0 {
            return 0.0;
        }
        let mut force = 0.0;
        if let Some((line, stiffness)) = self.tether {
            let place = layout.place(i, at);
            let near = match strip.near[i] {
                UNKNOWN => line.nearest(place, None),
                stretch => line.near(place, stretch as usize),
            };
            if let Some(near) = near {
                let way = |leg: usize| layout.stretch(leg, &strip.at).length();
                let share = 0.5 * (way(i) + way(layout.after(i))) * stiffness[near.stretch];
                force += share * (place - near.place).dot(layout.extents[i]);
            }
        }
        if let Some((reach, ends)) = self.barrier {
            force += barrier(ends[i], at, length, reach).0;
        }
        force / length
    }
}
