//! Straight lines: an open one as paths are straightened, a closed one across its seam too.

use super::{
    SmoothWorkspace,
    driver::Smoother,
    engine::{Done, Plan},
    strip::{Strip, UNKNOWN, share_on, turn_into},
};
use crate::geodesic::inner::InnerPath;
use crate::surface::{InnerPoint, Surface};

/// How often a closed line is straightened across its seam.
const SEAMS: usize = 8;
/// What counts as shorter.
const SHORTER: f64 = 1.0 - 1e-11;

impl Smoother<'_, '_> {
    /// An open line, straightened as paths are.
    pub(super) fn straightened(&mut self) -> Done {
        let SmoothWorkspace { finder, strip, path, .. } = &mut *self.workspace;
        finder.continue_inner(self.surface, &strip.start, &strip.end, &mut strip.sides, path);
        let met_bound = path.frozen;
        set_path(self.surface, strip, path);
        self.watch.see(strip);
        Done { rounds: 1, met_bound, ..Done::default() }
    }

    /// Straightens a closed line as an open one that begins and ends at a crossing, again and again, until that makes it no
    /// shorter.
    pub(super) fn tightened(&mut self, plan: &Plan, mut done: Done) -> Done {
        for _ in 0..SEAMS {
            if self.watch.is_stopped() {
                return done;
            }
            let SmoothWorkspace { finder, strip, path, kept, around, engine, .. } = &mut *self.workspace;
            let surface = self.surface;
            kept.copy_from(strip);
            let length = strip.length(surface);
            let cut = (0..strip.len()).max_by(|a, b| {
                let room = |i: usize| strip.at[i].min(1.0 - strip.at[i]) * surface.length(strip.sides[i]);
                room(*a).total_cmp(&room(*b))
            });
            let Some(cut) = cut else { return done };
            strip.rotate(cut);
            let (h, at) = (strip.sides[0], strip.at[0]);
            let (start, end) = (InnerPoint::on_side(surface.twin(h), 1.0 - at), InnerPoint::on_side(h, at));
            finder.continue_inner(surface, &start, &end, &mut strip.sides[1..], path);
            strip.clear();
            around.clear();
            for (h, at) in path.strip.iter().zip(&path.at) {
                strip.push(surface, *h, *at, 0.0, false);
            }
            let joins = turn_into(surface, &path.end, path.start.face, around);
            for h in around.iter() {
                strip.push(surface, *h, share_on(surface, &path.end, *h), 0.0, false);
            }
            strip.close_seam(surface);
            if !joins || strip.len() < 3 {
                strip.copy_from(kept);
                return done;
            }
            strip.measure(surface);
            if strip.length(surface) >= length * SHORTER {
                strip.copy_from(kept);
                return done;
            }
            self.watch.see(strip);
            let more = engine.relax(surface, strip, plan, self.watch);
            done.add(more);
            if more.collapsed {
                return done;
            }
            if strip.length(surface) > length {
                strip.copy_from(kept);
                return done;
            }
        }
        done
    }
}

/// A path as a strip.
fn set_path(surface: &Surface, strip: &mut Strip, path: &InnerPath) {
    (strip.start, strip.end) = (path.start, path.end);
    strip.sides.clone_from(&path.strip);
    strip.at.clone_from(&path.at);
    strip.fixed.clear();
    strip.fixed.resize(path.strip.len(), false);
    strip.near.clear();
    strip.near.resize(path.strip.len(), UNKNOWN);
    strip.measure(surface);
}
