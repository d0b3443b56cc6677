//! An independent judge of smoothed lines: adjacency, lengths and angles from the positions in the file.

use std::f64::consts::{PI, TAU};

use bevy_surface_splines::{
    geodesic::Crossing,
    smooth::{Smoothed, SmoothingMode, SurfacePolyline},
    surface::SurfacePoint,
};
use glam::DVec3;

use super::{lines::Line, settings::Setting};
use crate::checker::{self, Topology};

/// A crossing this near to an end of its side is at the vertex.
const AT_VERTEX: f64 = 1e-9;
/// A stretch this short, as a share of the side where the line turns, has no direction: places on a side are rounded by its length.
const NO_WAY: f64 = 1e-12;
/// What rounding may add, as a share.
const ROUNDING: f64 = 1e-9;

pub(crate) struct Judge<'a> {
    pub(crate) topology: &'a Topology,
}

impl Judge<'_> {
    /// Judges a line that was smoothed.
    pub(crate) fn judge(&self, line: &Line, smoothed: &Smoothed, setting: &Setting) -> Result<(), String> {
        self.check_strip(&smoothed.line)?;
        if smoothed.met_bound {
            return Err(format!("met its bound after {} rounds, {} steps", smoothed.rounds, smoothed.steps));
        }
        let spelled = |point: &SurfacePoint| (point.face.0, point.weights);
        if !line.line.is_closed() {
            for (a, b) in line.line.ends().iter().zip(&smoothed.line.ends()) {
                if !checker::same_place(self.topology, spelled(a), spelled(b)) {
                    return Err("an end moved".to_owned());
                }
            }
        }
        let [before, after] = [&line.line, &smoothed.line].map(|line| self.measure(line));
        for (given, measured, what) in [
            (smoothed.before.length, before.0, "length before"),
            (smoothed.after.length, after.0, "length"),
            (smoothed.before.total_turn, before.1, "total turn before"),
            (smoothed.after.total_turn, after.1, "total turn"),
        ] {
            let room = if what.starts_with("length") { ROUNDING } else { 1e-3 };
            let unsure = match what {
                "total turn before" => before.2,
                "total turn" => after.2,
                _ => 0.0,
            };
            let off = (given - measured).abs();
            if off.is_nan() || off > room * (1.0 + measured) + unsure {
                return Err(format!("{what} given as {given:.9}, measures {measured:.9}"));
            }
        }
        let shrinks = matches!(setting.smoothing.mode, SmoothingMode::Geodesic | SmoothingMode::Budget { .. });
        if shrinks && after.0 > before.0 * (1.0 + ROUNDING) {
            return Err(format!("grew from {} to {}", before.0, after.0));
        }
        let calms = match setting.smoothing.mode {
            SmoothingMode::Geodesic | SmoothingMode::Tether { .. } => true,
            SmoothingMode::Stencil { scale, .. } => scale <= 1.0,
            _ => false,
        };
        if calms && after.1 > before.1 + 1e-5 * (1.0 + before.1) {
            return Err(format!("total turn grew from {} to {}", before.1, after.1));
        }
        Ok(())
    }

    /// Consecutive crossings share a face, and none leads back at once.
    fn check_strip(&self, line: &SurfacePolyline) -> Result<(), String> {
        let crossings = line.crossings();
        let closing = if line.is_closed() { crossings.first() } else { None };
        let pairs = crossings.iter().zip(crossings[1.min(crossings.len())..].iter().chain(closing));
        for (a, b) in pairs {
            match self.topology.across(a.face.0, usize::from(a.side)) {
                Some((face, side)) if face == b.face.0 && side != usize::from(b.side) => {}
                _ => return Err(format!("torn or turning back at {}", a.face)),
            }
        }
        if let (false, Some(first), Some(last)) = (line.is_closed(), crossings.first(), crossings.last()) {
            let [start, end] = line.ends();
            let into = self.topology.across(last.face.0, usize::from(last.side));
            if start.face != first.face || into.map(|(face, _)| face) != Some(end.face.0) {
                return Err("its ends lie in other faces".to_owned());
            }
        }
        if crossings.iter().any(|c| !(0.0..=1.0).contains(&c.at)) || (line.is_closed() && crossings.len() < 3) {
            return Err("crossings beyond their sides, or too few".to_owned());
        }
        Ok(())
    }

    fn place(&self, c: &Crossing) -> DVec3 {
        let p = self.topology.places(c.face.0);
        let (a, b) = (p[usize::from(c.side)], p[(usize::from(c.side) + 1) % 3]);
        a * (1.0 - c.at) + b * c.at
    }

    /// Length, sum of the turns' sizes, and how far that sum may be off because places are rounded: the direction of a stretch is known to
    /// what rounding is beside its length, and one that is no longer than that has none.
    fn measure(&self, line: &SurfacePolyline) -> (f64, f64, f64) {
        let crossings = line.crossings();
        let n = crossings.len();
        let blend = |p: &SurfacePoint| {
            let [a, b, c] = self.topology.places(p.face.0);
            a * p.weights[0] + b * p.weights[1] + c * p.weights[2]
        };
        let mut places: Vec<DVec3> = crossings.iter().map(|c| self.place(c)).collect();
        if line.is_closed() {
            places.insert(0, places[n - 1]);
            places.push(places[1]);
        } else {
            let [start, end] = line.ends();
            places.insert(0, blend(&start));
            places.push(blend(&end));
        }
        let stretches = if line.is_closed() { &places[..=n] } else { &places[..] };
        let length = stretches.windows(2).fold(0.0, |sum, w| sum + w[0].distance(w[1]));
        let largest = places.iter().fold(0.0_f64, |most, p| most.max(p.abs().max_element()));
        let direction = |a: DVec3, b: DVec3| (8.0 * f64::EPSILON * largest / a.distance(b)).min(PI);
        let mut unsure = 0.0;
        let mut turn = 0.0;
        let mut i = 0;
        while i < n {
            let first = i;
            let vertex = self.vertex_at(&crossings[i]);
            if let Some(vertex) = vertex {
                while i + 1 < n && self.vertex_at(&crossings[i + 1]) == Some(vertex) {
                    i += 1;
                }
                turn += self.turn_about(vertex, crossings, first, i, places[first], places[i + 2]);
            } else {
                turn += self.turn_over(&crossings[i], places[i], places[i + 1], places[i + 2]);
            }
            unsure += direction(places[first], places[first + 1]) + direction(places[i + 1], places[i + 2]);
            i += 1;
        }
        (length, turn, unsure)
    }

    fn vertex_at(&self, c: &Crossing) -> Option<u32> {
        let t = self.topology.corners[c.face.0 as usize];
        if c.at <= AT_VERTEX {
            Some(t[usize::from(c.side)])
        } else if c.at >= 1.0 - AT_VERTEX {
            Some(t[(usize::from(c.side) + 1) % 3])
        } else {
            None
        }
    }

    fn turn_over(&self, c: &Crossing, before: DVec3, here: DVec3, after: DVec3) -> f64 {
        let p = self.topology.places(c.face.0);
        let side = p[(usize::from(c.side) + 1) % 3] - p[usize::from(c.side)];
        let (a, b) = (before - here, after - here);
        if a.length() <= NO_WAY * side.length() || b.length() <= NO_WAY * side.length() {
            return 0.0;
        }
        (angle(a, side) + angle(b, side) - PI).abs()
    }

    /// The turn at a vertex, as a share of its total angle.
    fn turn_about(
        &self,
        vertex: u32,
        crossings: &[Crossing],
        first: usize,
        last: usize,
        before: DVec3,
        after: DVec3,
    ) -> f64 {
        let here = self.topology.positions[vertex as usize];
        let spoke = |c: &Crossing| {
            let far = self.topology.far_end(c.face.0, usize::from(c.side), vertex);
            self.topology.positions[far as usize] - here
        };
        let none = NO_WAY * spoke(&crossings[first]).length();
        if before.distance(here) <= none || after.distance(here) <= none {
            return 0.0;
        }
        let corner = |face: u32| {
            let t = self.topology.corners[face as usize];
            let others: Vec<DVec3> =
                t.iter().filter(|v| **v != vertex).map(|v| self.topology.positions[*v as usize] - here).collect();
            if others.len() == 2 { angle(others[0], others[1]) } else { 0.0 }
        };
        let mut beside = angle(before - here, spoke(&crossings[first])) + angle(after - here, spoke(&crossings[last]));
        for c in &crossings[first + 1..=last] {
            beside += corner(c.face.0);
        }
        // The whole angle about the vertex, and whether it is on the boundary.
        let c = &crossings[first];
        let mut whole = corner(c.face.0);
        let mut round = false;
        let mut met = 0;
        for (face, _) in self.topology.fan(vertex, c.face.0, usize::from(c.side)) {
            met += 1;
            if face == c.face.0 || met > self.topology.corners.len() {
                round = true;
                break;
            }
            whole += corner(face);
        }
        if round { (TAU / whole * beside - PI).abs() } else { 0.0 }
    }
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
