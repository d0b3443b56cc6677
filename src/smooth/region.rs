//! The boundary of a selection of faces, as lines.

use std::collections::HashSet;

use super::{SurfacePolyline, strip::Strip};
use crate::surface::{FaceId, HalfEdge, InnerPoint, PointError, Surface};

impl SurfacePolyline {
    /// The lines between some faces and all others, the faces to their left.
    ///
    /// They run along sides, from vertex to vertex, on the strip of selected faces inside: a jagged line, to be smoothed. Where the
    /// selection reaches the surface's own boundary a line ends there. Corners of a single face that juts out are
    /// cut, and what is left of fewer than three faces is no line.
    ///
    /// Cost: linear in the faces given.
    ///
    /// # Errors
    /// [`PointError`] if a face does not exist or was dropped.
    pub fn around_faces(surface: &Surface, faces: &[FaceId]) -> Result<Vec<Self>, PointError> {
        let mut selected = HashSet::with_capacity(faces.len());
        for face in faces {
            selected.insert(surface.inner_face(*face)?);
        }
        let inside = |h: HalfEdge| h.is_some() && selected.contains(&h.face());
        let is_rim = |h: HalfEdge| surface.twin(h).is_some() && !inside(surface.twin(h));
        let mut rims: Vec<HalfEdge> = selected.iter().flat_map(|f| (0..3).map(|k| HalfEdge::new(*f, k))).collect();
        rims.retain(|h| is_rim(*h));
        rims.sort_unstable();
        // Open lines first: they begin where no side of the rim comes before.
        let mut seen = HashSet::with_capacity(rims.len());
        let starts: Vec<HalfEdge> = rims.iter().copied().filter(|h| before(surface, *h, &inside).is_none()).collect();
        let (mut lines, mut spokes) = (Vec::new(), Vec::new());
        for (first, open) in starts.iter().map(|h| (*h, true)).chain(rims.iter().map(|h| (*h, false))) {
            if seen.contains(&first) {
                continue;
            }
            let mut strip = Strip { closed: !open, ..Strip::default() };
            strip.start = corner(first, false);
            let mut h = first;
            loop {
                seen.insert(h);
                strip.end = corner(h, true);
                let Some(next) = after(surface, h, &inside, &mut spokes) else { break };
                spokes.iter().for_each(|side| {
                    strip.push(surface, *side, 0.0, 0.0, false);
                });
                if next == first || seen.contains(&next) {
                    break;
                }
                h = next;
            }
            lines.extend(Self::of(surface, strip).ok());
        }
        Ok(lines)
    }
}

/// Where a side begins or ends.
fn corner(h: HalfEdge, end: bool) -> InnerPoint {
    let mut weights = [0.0; 3];
    weights[if end { h.next().side() } else { h.side() }] = 1.0;
    InnerPoint { face: h.face(), weights }
}

/// The side of the rim that follows, and the sides about the vertex between, which lies to the right; none at the boundary.
fn after(
    surface: &Surface,
    h: HalfEdge,
    inside: &impl Fn(HalfEdge) -> bool,
    spokes: &mut Vec<HalfEdge>,
) -> Option<HalfEdge> {
    spokes.clear();
    let mut side = h.next();
    loop {
        let twin = surface.twin(side);
        if !twin.is_some() {
            return None;
        }
        if !inside(twin) {
            return Some(side);
        }
        spokes.push(side);
        side = twin.next();
    }
}

/// The side of the rim before; none at the boundary.
fn before(surface: &Surface, h: HalfEdge, inside: &impl Fn(HalfEdge) -> bool) -> Option<HalfEdge> {
    let mut side = h.prev();
    loop {
        let twin = surface.twin(side);
        if !twin.is_some() {
            return None;
        }
        if !inside(twin) {
            return Some(side);
        }
        side = twin.prev();
    }
}
