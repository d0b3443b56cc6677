//! Straightening: the strip goes round the other side of the sharpest bend, again and again.

use bevy_surface_splines::surface::SurfacePoint;
use glam::DVec2;

use super::{
    funnel::{self, Bend},
    mesh::{Mesh, NONE},
    path::Crossing,
    unfold::{Portal, Unfolded},
};

/// Bends with a smaller `1 − cos` of their turn are none: rounding.
const STRAIGHT: f64 = 1e-10;

#[derive(Default)]
pub(super) struct Straightener {
    unfolded: Unfolded,
    bends: Vec<Bend>,
    /// Vertices on the boundary, which have no other side.
    kept: Vec<u32>,
    spliced: Vec<u32>,
}

impl Straightener {
    /// Straightens a strip and gives the line's crossings of its sides.
    pub(super) fn straighten(
        &mut self,
        mesh: &Mesh,
        strip: &mut Vec<u32>,
        from: &SurfacePoint,
        to: &SurfacePoint,
    ) -> Vec<Crossing> {
        self.kept.clear();
        let mut last = NONE;
        // Twice the faces of the strip found: where the published program gives up.
        for _ in 0..2 * strip.len() {
            if !self.pull(mesh, strip, from, to) {
                return Vec::new();
            }
            let Some(bend) = self.sharpest() else { break };
            if bend.vertex == last {
                break;
            }
            last = bend.vertex;
            if !self.go_round(mesh, strip, &bend) {
                self.kept.push(bend.vertex);
            }
        }
        if !self.pull(mesh, strip, from, to) {
            return Vec::new();
        }
        self.crossings()
    }

    /// Lays the whole strip out anew and pulls the string through it.
    fn pull(&mut self, mesh: &Mesh, strip: &[u32], from: &SurfacePoint, to: &SurfacePoint) -> bool {
        let laid_out = self.unfolded.lay_out(mesh, strip, from, to);
        if laid_out {
            funnel::pull(&self.unfolded, &mut self.bends);
        }
        laid_out
    }

    fn sharpest(&self) -> Option<Bend> {
        let mut best = None;
        let mut most = STRAIGHT;
        for (i, bend) in self.bends.iter().enumerate() {
            let before = if i == 0 { self.unfolded.start } else { self.bends[i - 1].place };
            let after = self.bends.get(i + 1).map_or(self.unfolded.end, |next| next.place);
            let cos = (bend.place - before).normalize_or_zero().dot((after - bend.place).normalize_or_zero());
            if 1.0 - cos > most && !self.kept.contains(&bend.vertex) {
                most = 1.0 - cos;
                best = Some(*bend);
            }
        }
        best
    }

    /// Leads the strip round the other side of a vertex; false if the boundary is in the way.
    fn go_round(&mut self, mesh: &Mesh, strip: &mut Vec<u32>, bend: &Bend) -> bool {
        let touches = |p: &Portal| p.left_vertex == bend.vertex || p.right_vertex == bend.vertex;
        let portals = &self.unfolded.portals;
        let before = portals[..bend.portal].iter().rev().take_while(|p| touches(p)).count();
        let after = portals[bend.portal..].iter().take_while(|p| touches(p)).count();
        // Portal i lies between faces i and i + 1.
        let (first, last) = (bend.portal - before, bend.portal + after);

        self.spliced.clear();
        let (mut face, mut behind) = (strip[first], strip[first + 1]);
        let end = strip[last];
        while face != end {
            let Some(next) = other_face_around(mesh, face, bend.vertex, behind) else { return false };
            (behind, face) = (face, next);
            if self.spliced.len() > mesh.nodes.len() {
                return false;
            }
            self.spliced.push(face);
        }
        strip.splice(first + 1..=last, self.spliced.iter().copied());
        remove_detours(strip);
        true
    }

    /// Where the line crosses each portal.
    fn crossings(&self) -> Vec<Crossing> {
        let mut bends = self.bends.iter().peekable();
        let mut from: (DVec2, u32) = (self.unfolded.start, NONE);
        let portals = self.unfolded.portals.iter().enumerate();
        portals
            .map(|(i, portal)| {
                while let Some(bend) = bends.next_if(|bend| bend.portal < i) {
                    from = (bend.place, bend.vertex);
                }
                let to = bends.peek().map_or((self.unfolded.end, NONE), |bend| (bend.place, bend.vertex));
                let at = if [from.1, to.1].contains(&portal.left_vertex) {
                    0.0
                } else if [from.1, to.1].contains(&portal.right_vertex) {
                    1.0
                } else {
                    share_of_crossing(portal, from.0, to.0)
                };
                Crossing { left: portal.left_vertex, right: portal.right_vertex, at }
            })
            .collect()
    }
}

/// Where a line meets a portal: 0 at its left end, 1 at its right one.
fn share_of_crossing(portal: &Portal, from: DVec2, to: DVec2) -> f64 {
    let along = to - from;
    let (left, right) = (along.perp_dot(portal.left - from), along.perp_dot(portal.right - from));
    if left == right { 0.5 } else { (left / (left - right)).clamp(0.0, 1.0) }
}

/// The neighbour of a face across its other side at a vertex, away from the one behind.
fn other_face_around(mesh: &Mesh, face: u32, vertex: u32, behind: u32) -> Option<u32> {
    let (corners, neighbours) = (&mesh.faces[face as usize], &mesh.nodes[face as usize].neighbours);
    let k = corners.iter().position(|&c| c == vertex)?;
    // The sides at corner k are k and k − 1.
    let next = if neighbours[k] == behind { neighbours[(k + 2) % 3] } else { neighbours[k] };
    (next != NONE).then_some(next)
}

/// Takes out faces that the strip enters and leaves through the same side.
fn remove_detours(strip: &mut Vec<u32>) {
    let mut kept = 0;
    for i in 0..strip.len() {
        let face = strip[i];
        if kept >= 2 && strip[kept - 2] == face {
            kept -= 1;
        } else if kept == 0 || strip[kept - 1] != face {
            strip[kept] = face;
            kept += 1;
        }
    }
    strip.truncate(kept);
}
