//! Edits that change which anchors there are, and in which order.

use std::f64::consts::PI;

use super::{EditError, HandleSide, SplineEnd};
use crate::curve::{Anchor, Handle, Join, Spline, handles};
use crate::geodesic::{PathError, PathFinder, PathQuality, inner::InnerPath, transport::angle_at};
use crate::surface::{PointError, Surface, SurfacePoint};

/// Handles whose directions differ from opposite by less than this (radians) make a smooth anchor where two ends become one.
const OPPOSITE: f64 = 1e-9;

impl Spline {
    pub(super) fn append(
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

    pub(super) fn delete(&mut self, surface: &Surface, finder: &mut PathFinder, anchor: u32) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        if self.anchors.len() <= if self.closed { 1 } else { 2 } {
            return Err(EditError::TooFewAnchors);
        }
        let neighbours = self.neighbours(i);
        if let (Some(before), Some(after)) = neighbours
            && !self.scheme.method.is_b_spline()
        {
            self.bridge_over(surface, finder, before, i, after)?;
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

    /// Lengthens the handles about an anchor that goes, so that one segment takes the place of two.
    fn bridge_over(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        before: usize,
        gone: usize,
        after: usize,
    ) -> Result<(), EditError> {
        // The lengths of the two control polygons stand for those of the two curves.
        let mut length = |from: usize, to: usize| -> Result<f64, EditError> {
            let (a, b) = (&self.anchors[from].outgoing, &self.anchors[to].incoming);
            let middle = finder.shortest(surface, &a.point(), &b.point())?.length();
            Ok(a.leg.length() + middle + b.leg.length())
        };
        let (left, right) = (length(before, gone)?, length(gone, after)?);
        if left + right <= 0.0 {
            return Ok(());
        }
        let share = (left / (left + right)).clamp(0.05, 0.95);
        let stretched = |anchor: &Anchor, handle: &Handle, factor: f64| {
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
        Ok(())
    }

    pub(super) fn straighten(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        segment: u32,
    ) -> Result<(), EditError> {
        let [i, j] = self.segment_anchors(segment)?;
        let (from, to) = (surface.inner_point(&self.anchors[i].point)?, surface.inner_point(&self.anchors[j].point)?);
        let mut path = InnerPath::default();
        finder.shortest_inner(surface, &from, &to, PathQuality::Default, &mut path)?;
        let third = 1.0 / 3.0;
        self.anchors[i].outgoing = handles::along(surface, &path.piece(surface, 0.0, third));
        self.anchors[i].middle = Some(path.piece(surface, third, 2.0 * third).to_outer(surface));
        let mut last = path.piece(surface, 2.0 * third, 1.0);
        last.reverse(surface);
        self.anchors[j].incoming = handles::along(surface, &last);
        for k in [i, j] {
            self.anchors[k].join = Join::Corner;
        }
        Ok(())
    }

    pub(super) fn close(&mut self, surface: &Surface, finder: &mut PathFinder) -> Result<(), EditError> {
        if self.closed {
            return Err(EditError::Closed);
        }
        let last = self.anchors.len().checked_sub(1).ok_or(EditError::TooFewAnchors)?;
        if last > 0 && surface.same_place(&self.anchors[0].point, &self.anchors[last].point) {
            let end = self.anchors.remove(last);
            self.anchors[0] = merged(surface, &end, &self.anchors[0])?;
        }
        self.closed = true;
        self.place_automatic_around(surface, finder, 0)
    }

    pub(super) fn open(&mut self, anchor: u32) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        if !self.closed {
            return Err(EditError::Open);
        }
        self.anchors.rotate_left(i);
        self.anchors.extend(self.anchors.first().cloned());
        self.closed = false;
        Ok(())
    }

    pub(super) fn reverse(&mut self, surface: &Surface) -> Result<(), PointError> {
        let middles = self.anchors.iter().map(|a| a.middle.as_ref().map(|m| m.reversed(surface)).transpose());
        let middles: Vec<_> = middles.collect::<Result<_, _>>()?;
        let n = self.anchors.len();
        self.anchors.reverse();
        if self.closed && n > 0 {
            self.anchors.rotate_right(1);
        }
        for (i, anchor) in self.anchors.iter_mut().enumerate() {
            std::mem::swap(&mut anchor.incoming, &mut anchor.outgoing);
            // Segment i runs where the last but i did, one earlier if the spline is open.
            let old = if self.closed { Some(n - 1 - i) } else { (n - 1 - i).checked_sub(1) };
            anchor.middle = old.and_then(|old| middles[old].clone());
        }
        Ok(())
    }

    pub(super) fn cut(&mut self, anchor: u32, keep: SplineEnd) -> Result<(), EditError> {
        let i = self.index(anchor)?;
        if self.closed {
            return Err(EditError::Closed);
        }
        let kept = match keep {
            SplineEnd::Start => 0..i + 1,
            SplineEnd::End => i..self.anchors.len(),
        };
        if kept.len() < 2 {
            return Err(EditError::TooFewAnchors);
        }
        self.anchors = self.anchors.drain(kept).collect();
        Ok(())
    }

    pub(super) fn join(
        &mut self,
        surface: &Surface,
        finder: &mut PathFinder,
        end: SplineEnd,
        other: &Self,
        at: SplineEnd,
    ) -> Result<(), EditError> {
        other.check(surface)?;
        if self.closed || other.closed {
            return Err(EditError::Closed);
        }
        let mut other = other.clone();
        let joins_head_on = (end == SplineEnd::End) == (at == SplineEnd::End);
        if joins_head_on {
            other.reverse(surface)?;
        }
        let (mut first, mut second) = match end {
            SplineEnd::End => (std::mem::take(&mut self.anchors), other.anchors),
            SplineEnd::Start => (other.anchors, std::mem::take(&mut self.anchors)),
        };
        if let (Some(a), Some(b)) = (first.last(), second.first()) {
            if surface.sheet(a.point.face)? != surface.sheet(b.point.face)? {
                return Err(PathError::NoPath { from: a.point, to: b.point }.into());
            }
            if surface.same_place(&a.point, &b.point) {
                second[0] = merged(surface, a, b)?;
                first.pop();
            }
        }
        let seam = first.len();
        first.append(&mut second);
        self.anchors = first;
        self.place_automatic_around(surface, finder, seam)
    }

    /// The two splines that an anchor of an open spline divides it into; both have the anchor.
    ///
    /// As edits: [`Cut`](super::SplineEdit::Cut) of the one, and the other made anew.
    ///
    /// # Errors
    /// [`EditError`] at the ends, for closed splines, and where there is no such anchor.
    pub fn split(&self, anchor: u32) -> Result<[Self; 2], EditError> {
        let part = |keep: SplineEnd| -> Result<Self, EditError> {
            let mut part = self.clone();
            part.cut(anchor, keep)?;
            if let Some(last) = part.anchors.last_mut() {
                last.middle = None;
            }
            Ok(part)
        };
        Ok([part(SplineEnd::Start)?, part(SplineEnd::End)?])
    }

    /// Whether every point and leg belongs to the surface, and enough of them.
    pub(crate) fn check(&self, surface: &Surface) -> Result<(), EditError> {
        if self.anchors.len() < if self.closed { 1 } else { 2 } {
            return Err(EditError::TooFewAnchors);
        }
        let first = self.anchors[0].point;
        for (i, anchor) in self.anchors.iter().enumerate() {
            surface.inner_point(&anchor.point)?;
            if surface.sheet(anchor.point.face)? != surface.sheet(first.face)? {
                return Err(PathError::NoPath { from: first, to: anchor.point }.into());
            }
            for side in [HandleSide::Incoming, HandleSide::Outgoing] {
                let handle = anchor.handle(side);
                let leg = InnerPath::from_outer(surface, &handle.leg)?;
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
            if let Some(middle) = &anchor.middle {
                InnerPath::from_outer(surface, middle)?;
            }
        }
        Ok(())
    }
}

/// The anchor that two ends in one place become: joined as both were where their handles allow it, smooth if they are
/// opposite, else a corner.
fn merged(surface: &Surface, end: &Anchor, start: &Anchor) -> Result<Anchor, EditError> {
    let mut out = start.clone();
    out.incoming = end.incoming.clone();
    out.join = Join::Corner;
    if end.join == Join::Automatic && start.join == Join::Automatic {
        out.join = Join::Automatic;
    } else if handles::has_say(surface, &out.incoming) && handles::has_say(surface, &out.outgoing) {
        let at = surface.inner_point(&out.point)?;
        let [incoming, outgoing] =
            [surface.inner_tangent(&out.incoming.heading)?, surface.inner_tangent(&out.outgoing.heading)?];
        let angle = angle_at(surface, &at, &incoming, &outgoing);
        if (angle.abs() - PI).abs() < OPPOSITE {
            let mirrored = end.join == Join::Mirrored
                && start.join == Join::Mirrored
                && out.incoming.wished_length == out.outgoing.wished_length;
            out.join = if mirrored { Join::Mirrored } else { Join::Smooth };
        }
    }
    Ok(out)
}
