//! Changes to a spline, as plain data with inverses.

use super::{Anchor, Join, Sampling, Scheme, Spline, handles};
use crate::geodesic::{PathError, PathFinder};
use crate::surface::{PointError, Surface, SurfacePoint};

/// One of the two handles of an anchor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum HandleSide {
    /// The handle of the segment that ends at the anchor.
    Incoming,
    /// The handle of the segment that begins at the anchor.
    Outgoing,
}

/// One of the two ends of an open spline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum SplineEnd {
    /// Before the first anchor.
    Start,
    /// After the last anchor.
    End,
}

/// A change to a spline.
///
/// Editor, undo, tests and game code all send these; [`Spline::apply`] gives the inverse.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum SplineEdit {
    /// Moves an anchor; its handles are carried along by parallel transport on the shortest path, and keep their lengths.
    MoveAnchor {
        /// Which anchor.
        anchor: u32,
        /// Where to.
        to: SurfacePoint,
    },
    /// Moves a handle; its leg is the shortest path. At a smooth join the partner turns with it and keeps its length, at a
    /// mirrored one it takes the length too. An automatic join becomes smooth.
    MoveHandle {
        /// Which anchor.
        anchor: u32,
        /// Which of its handles.
        side: HandleSide,
        /// Where to.
        to: SurfacePoint,
    },
    /// Adds an anchor, a corner with handles of no length, beyond an end of an open spline.
    Append {
        /// Which end.
        end: SplineEnd,
        /// Where.
        at: SurfacePoint,
    },
    /// Removes an anchor. Between two others, their segments become one with the outer tangents, its handles longer by
    /// the share that went; a mirrored neighbour becomes smooth, since one of its handles alone grew.
    Delete {
        /// Which anchor.
        anchor: u32,
    },
    /// Changes how the handles of an anchor depend on each other, and moves them as that asks.
    SetJoin {
        /// Which anchor.
        anchor: u32,
        /// How.
        join: Join,
    },
    /// Changes how the spline is traced.
    SetScheme(Scheme),
    /// Replaces everything.
    Replace(Spline),
    /// Puts back what another edit changed, bit for bit: the inverses are of this kind.
    Restore(SplinePatch),
}

/// What turns one version of a spline into another: a range of anchors and the two settings.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct SplinePatch {
    /// Hash of the version it applies to.
    version: u64,
    at: u32,
    remove: u32,
    insert: Vec<Anchor>,
    closed: bool,
    scheme: Scheme,
}

impl SplinePatch {
    /// The smallest patch that turns `from` into `to`.
    fn between(from: &Spline, to: &Spline) -> Self {
        let (a, b) = (&from.anchors, &to.anchors);
        let same = |(x, y): &(&Anchor, &Anchor)| hash_anchor(x) == hash_anchor(y) && x == y;
        let at = a.iter().zip(b).take_while(same).count();
        let rest = a.len().min(b.len()) - at;
        let kept = a.iter().rev().zip(b.iter().rev()).take(rest).take_while(same).count();
        Self {
            version: hash_spline(from),
            at: at as u32,
            remove: (a.len() - kept - at) as u32,
            insert: b[at..b.len() - kept].to_vec(),
            closed: to.closed,
            scheme: to.scheme,
        }
    }
}

/// Hashes every bit of a spline, so that a patch knows the version it was made for.
fn hash_spline(spline: &Spline) -> u64 {
    let mut words = Words::default();
    words.mix(u64::from(spline.closed));
    words.scheme(&spline.scheme);
    spline.anchors.iter().for_each(|a| words.mix(hash_anchor(a)));
    words.0
}

fn hash_anchor(anchor: &Anchor) -> u64 {
    let mut words = Words::default();
    words.point(&anchor.point);
    words.mix(anchor.join as u64);
    for handle in [&anchor.incoming, &anchor.outgoing] {
        let (leg, heading) = (&handle.leg, &handle.heading);
        words.point(&leg.start);
        words.point(&leg.end);
        for c in &leg.crossings {
            words.mix(u64::from(c.face.0) << 8 | u64::from(c.side));
            words.mix(c.at.to_bits());
        }
        words.mix(u64::from(heading.face.0));
        for x in [leg.length, heading.vector.x, heading.vector.y, handle.wished_length] {
            words.mix(x.to_bits());
        }
    }
    words.0
}

#[derive(Default)]
struct Words(u64);

impl Words {
    fn mix(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd).wrapping_add(0x9e37_79b9_7f4a_7c15);
        self.0 ^= self.0 >> 32;
    }

    fn scheme(&mut self, scheme: &Scheme) {
        self.mix(scheme.method as u64 | u64::from(scheme.on_curve) << 8);
        match scheme.sampling {
            Sampling::Levels(levels) => self.mix(u64::from(levels)),
            Sampling::Length(length) => self.mix(length.to_bits()),
            Sampling::Adaptive { turn, length } => {
                self.mix(turn.to_bits());
                self.mix(length.map_or(1, f64::to_bits));
            }
        }
    }

    fn point(&mut self, point: &SurfacePoint) {
        self.mix(u64::from(point.face.0));
        point.weights.iter().for_each(|w| self.mix(w.to_bits()));
    }
}

/// Why an edit was refused; the spline is as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EditError {
    /// No such anchor.
    #[error("there is no anchor {anchor}: the spline has {count}, counted from 0")]
    NoSuchAnchor {
        /// The anchor asked for.
        anchor: u32,
        /// How many there are.
        count: usize,
    },
    /// A closed spline has no ends.
    #[error("a closed spline has no end to add to: open it first")]
    Closed,
    /// Too few anchors would be left.
    #[error("a spline keeps at least two anchors: remove the spline instead")]
    TooFewAnchors,
    /// The patch was made for another version of the spline.
    #[error("this restores another version of the spline: undo what came after it first")]
    OtherVersion,
    /// A handle of a whole spline does not begin at its anchor, or its length is not a length.
    #[error("a handle of anchor {anchor} does not belong to it: make the spline anew on this surface")]
    BadHandle {
        /// Which anchor.
        anchor: u32,
    },
    /// A point does not belong to the surface.
    #[error(transparent)]
    Point(#[from] PointError),
    /// The place cannot be reached.
    #[error(transparent)]
    Path(#[from] PathError),
}

impl Spline {
    /// Applies an edit and gives its inverse, which holds what was touched exactly as it was.
    ///
    /// Cost: a few shortest paths and walks; nothing is traced.
    ///
    /// # Errors
    /// [`EditError`] if the edit names an anchor or a place that is not there; the spline is then as it was.
    pub fn apply(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        edit: &SplineEdit,
    ) -> Result<SplineEdit, EditError> {
        let mut next = self.clone();
        match edit {
            SplineEdit::MoveAnchor { anchor, to } => next.move_anchor(surface, finder, *anchor, *to)?,
            SplineEdit::MoveHandle { anchor, side, to } => next.move_handle(surface, finder, *anchor, *side, *to)?,
            SplineEdit::Append { end, at } => next.append(surface, finder, *end, *at)?,
            SplineEdit::Delete { anchor } => next.delete(surface, finder, *anchor)?,
            SplineEdit::SetJoin { anchor, join } => next.set_join(surface, finder, *anchor, *join)?,
            SplineEdit::SetScheme(scheme) => next.scheme = *scheme,
            SplineEdit::Replace(spline) => {
                spline.check(surface)?;
                next = spline.clone();
            }
            SplineEdit::Restore(patch) => next.restore(patch)?,
        }
        let inverse = SplinePatch::between(&next, self);
        *self = next;
        Ok(SplineEdit::Restore(inverse))
    }

    fn index(&self, anchor: u32) -> Result<usize, EditError> {
        let count = self.anchors.len();
        if (anchor as usize) < count { Ok(anchor as usize) } else { Err(EditError::NoSuchAnchor { anchor, count }) }
    }

    fn move_anchor(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: u32,
        to: SurfacePoint,
    ) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        let to = handles::without_negative_zeros(to);
        if self.anchors[i].point.same_bits(&to) {
            return Ok(());
        }
        let path = finder.shortest(surface, &self.anchors[i].point, &to)?;
        self.anchors[i] = handles::carry(surface, &self.anchors[i], &path, to)?;
        self.place_automatic_around(surface, finder, i)
    }

    /// Places the handles of an anchor and of its neighbours where these are automatic.
    fn place_automatic_around(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: usize,
    ) -> Result<(), EditError> {
        let (before, after) = self.neighbours(anchor);
        for i in [before, Some(anchor), after].into_iter().flatten() {
            if self.anchors[i].join == Join::Automatic {
                handles::place_automatic(surface, finder, self, i)?;
            }
        }
        Ok(())
    }

    fn move_handle(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: u32,
        side: HandleSide,
        to: SurfacePoint,
    ) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        let anchor = &mut self.anchors[i];
        let point = anchor.point;
        let mut moved = handles::towards(surface, finder, &point, &to)?;
        let (own, partner) = match side {
            HandleSide::Incoming => (&mut anchor.incoming, &mut anchor.outgoing),
            HandleSide::Outgoing => (&mut anchor.outgoing, &mut anchor.incoming),
        };
        if anchor.join == Join::Automatic {
            anchor.join = Join::Smooth;
        }
        if handles::has_say(surface, &moved) {
            match anchor.join {
                Join::Corner | Join::Automatic => {}
                Join::Smooth => *partner = handles::opposite(surface, &point, &moved, partner.wished_length)?,
                Join::Mirrored => *partner = handles::opposite(surface, &point, &moved, moved.wished_length)?,
            }
        } else {
            moved.heading = own.heading;
        }
        *own = moved;
        Ok(())
    }

    fn append(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        end: SplineEnd,
        at: SurfacePoint,
    ) -> Result<(), EditError> {
        if self.closed {
            return Err(EditError::Closed);
        }
        let place = match end {
            SplineEnd::Start => 0,
            SplineEnd::End => self.anchors.len(),
        };
        let anchor = handles::bare_anchor(surface, at)?;
        let old_end = if place == 0 { self.anchors.first() } else { self.anchors.last() };
        if let Some(old_end) = old_end {
            finder.shortest(surface, &old_end.point, &at)?; // on another sheet it could never be traced
        }
        self.anchors.insert(place, anchor);
        self.place_automatic_around(surface, finder, place)
    }

    fn delete(&mut self, surface: &Surface, finder: &mut PathFinder, anchor: u32) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        if self.anchors.len() <= 2 {
            return Err(EditError::TooFewAnchors);
        }
        if let (Some(before), Some(after)) = self.neighbours(i) {
            // The lengths of the two control polygons stand for those of the two curves.
            let mut length = |from: usize, to: usize| -> Result<f64, EditError> {
                let (a, b) = (&self.anchors[from].outgoing, &self.anchors[to].incoming);
                let middle = finder.shortest(surface, &a.point(), &b.point())?.length();
                Ok(a.leg.length() + middle + b.leg.length())
            };
            let (left, right) = (length(before, i)?, length(i, after)?);
            if left + right > 0.0 {
                let share = (left / (left + right)).clamp(0.05, 0.95);
                let stretched = |anchor: &Anchor, handle: &super::Handle, factor: f64| {
                    let heading = surface.inner_tangent(&handle.heading)?;
                    handles::ahead(surface, &anchor.point, &heading, handle.wished_length * factor)
                };
                let anchor = &self.anchors[before];
                let outgoing = stretched(anchor, &anchor.outgoing, 1.0 / share)?;
                let anchor = &self.anchors[after];
                let incoming = stretched(anchor, &anchor.incoming, 1.0 / (1.0 - share))?;
                self.anchors[before].outgoing = outgoing;
                self.anchors[after].incoming = incoming;
                for k in [before, after] {
                    if self.anchors[k].join == Join::Mirrored {
                        self.anchors[k].join = Join::Smooth;
                    }
                }
            }
        }
        self.anchors.remove(i);
        let n = self.anchors.len();
        for k in [(i + n - 1) % n, i % n] {
            if self.anchors[k].join == Join::Automatic {
                handles::place_automatic(surface, finder, self, k)?;
            }
        }
        Ok(())
    }

    fn set_join(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        anchor: u32,
        join: Join,
    ) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        self.anchors[i].join = join;
        match join {
            Join::Corner => {}
            Join::Smooth => handles::align(surface, &mut self.anchors[i], false)?,
            Join::Mirrored => handles::align(surface, &mut self.anchors[i], true)?,
            Join::Automatic => handles::place_automatic(surface, finder, self, i)?,
        }
        Ok(())
    }

    fn restore(&mut self, patch: &SplinePatch) -> Result<(), EditError> {
        let (at, remove) = (patch.at as usize, patch.remove as usize);
        let end = at.checked_add(remove).filter(|end| *end <= self.anchors.len()).ok_or(EditError::OtherVersion)?;
        if patch.version != hash_spline(self) {
            return Err(EditError::OtherVersion);
        }
        self.anchors.splice(at..end, patch.insert.iter().cloned());
        (self.closed, self.scheme) = (patch.closed, patch.scheme);
        Ok(())
    }

    /// Whether every point and leg belongs to the surface, and enough of them.
    fn check(&self, surface: &Surface) -> Result<(), EditError> {
        if self.anchors.len() < 2 {
            return Err(EditError::TooFewAnchors);
        }
        let first = self.anchors[0].point;
        for (i, anchor) in self.anchors.iter().enumerate() {
            surface.inner_point(&anchor.point)?;
            if surface.sheet(anchor.point.face) != surface.sheet(first.face) {
                return Err(PathError::NoPath { from: first, to: anchor.point }.into());
            }
            for handle in [&anchor.incoming, &anchor.outgoing] {
                let leg = crate::geodesic::inner::InnerPath::from_outer(surface, &handle.leg)?;
                let lengths = [handle.wished_length, handle.leg.length];
                let tolerance = 1e-9 * surface.diagonal();
                if !surface.same_place(&handle.leg.start, &anchor.point)
                    || lengths.iter().any(|l| !l.is_finite() || *l < 0.0)
                    || (leg.length - handle.leg.length).abs() > tolerance
                {
                    return Err(EditError::BadHandle { anchor: i as u32 });
                }
                surface.inner_tangent_at(&anchor.point, &handle.heading)?;
            }
        }
        Ok(())
    }
}
