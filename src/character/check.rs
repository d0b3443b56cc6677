//! What a character must be, wherever it comes from.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::locate::Step;
use super::stored::{FARTHEST, LONGEST, MOST_DEGREES, MOST_SCALE};
use super::{Character, CharacterError, CharacterFault, Clip, JoinChange, Keys, Part, WeightSource};
use crate::skin::{Chain, HandleShape, JoinKind, JoinRules};

/// What is wrong, and with what.
#[derive(Debug)]
pub(super) struct Flaw {
    /// Where it stands in a file.
    pub(super) at: Vec<Step>,
    /// The element, for people.
    pub(super) element: String,
    pub(super) fault: CharacterFault,
}

/// Names and ids.
const LONGEST_NAME: usize = 1_000;
/// Parts, clips, and tracks of a clip.
const MOST_PARTS: usize = 10_000;
/// Corners of an outline or a cage: all its edges are compared with one another.
const MOST_CORNERS: usize = 256;
/// Clips times what any of them moves.
const MOST_CURVES: usize = 100_000;
/// Triangles of the weights of a part.
const TRIANGLES: [u32; 2] = [16, 20_000];
/// Changes of joins, each as often as there are shapes of its name.
const MOST_CHANGES: usize = 20_000;
/// Segments times the joints that they follow, of all parts: a microsecond and 300 bytes each.
const MOST_PAIRS: usize = 200_000;
/// Triangles times joints of parts whose weights are solved for. A triangle takes some 13 microseconds for a joint, and more in
/// thin outlines.
const MOST_SOLVED: usize = 20_000;

impl Character {
    /// Checks that all fits together, as reading does: for characters that were changed.
    ///
    /// # Errors
    /// [`CharacterError::Fault`] for the first thing that does not.
    pub fn check(&self) -> Result<(), CharacterError> {
        self.assigned().map(|_| ())
    }

    /// The part of each shape.
    pub(super) fn assigned(&self) -> Result<Vec<Option<usize>>, CharacterError> {
        self.find_flaw().map_err(|Flaw { element, fault, .. }| CharacterError::Fault { place: None, element, fault })
    }

    /// The first thing that does not fit, or the part of each shape.
    pub(super) fn find_flaw(&self) -> Result<Vec<Option<usize>>, Flaw> {
        self.check_joints()?;
        self.check_drawing()?;
        self.check_weights(&self.weights, None, &[Step::Field("weights")], "weights of all parts")?;
        limit_count("parts", self.parts.len(), MOST_PARTS, "parts")?;
        let mut names = HashSet::new();
        for (number, part) in self.parts.iter().enumerate() {
            self.check_part(number, part, &mut names)?;
        }
        let assigned = self.assign()?;
        self.check_joins(&assigned)?;
        self.check_cost(&assigned)?;
        limit_count("clips", self.clips.len(), MOST_PARTS, "clips")?;
        let mut names = HashSet::new();
        for (number, clip) in self.clips.iter().enumerate() {
            self.check_clip(number, clip, &mut names)?;
        }
        let keys = self.clips.iter().flat_map(|clip| &clip.tracks).map(|track| track.keys.len()).sum();
        limit_count("clips", keys, Self::MOST_KEYS, "keys")?;
        // Players keep a curve for each, as clips bring back to rest what others move.
        let tracks = self.clips.iter().flat_map(|clip| &clip.tracks);
        let moved: HashSet<_> = tracks.map(|track| (track.joint, std::mem::discriminant(&track.keys))).collect();
        limit_count("clips", moved.len() * self.clips.len(), MOST_CURVES, "clips times what they move of joints")?;
        Ok(assigned)
    }

    fn check_joints(&self) -> Result<(), Flaw> {
        let whole = |fault| flaw(&[Step::Field("joints")], "the character", fault);
        if self.joints.is_empty() {
            return Err(whole(CharacterFault::NoJoints));
        }
        limit_count("joints", self.joints.len(), Self::MOST_JOINTS, "joints")?;
        let mut names = HashSet::new();
        for (number, joint) in self.joints.iter().enumerate() {
            let (at, element) = ([Step::Field("joints"), Step::Item(number)], format!("joint `{}`", joint.name));
            let failed = |fault| flaw(&at, &element, fault);
            check_name(&joint.name).map_err(failed)?;
            if !names.insert(&joint.name) {
                return Err(failed(CharacterFault::SameName { what: "joint" }));
            }
            if joint.parent.is_some_and(|parent| parent >= number) {
                return Err(failed(CharacterFault::ParentLater));
            }
            check_angle(joint.angle).map_err(failed)?;
            for place in [Some(joint.at), joint.tip].into_iter().flatten() {
                far("its place", place).map_err(failed)?;
            }
        }
        Ok(())
    }

    fn check_drawing(&self) -> Result<(), Flaw> {
        let at = [Step::Field("drawing")];
        let drawing = || self.drawing_path.clone();
        if !(1..=4096).contains(&self.drawing_path.len()) {
            let fault = CharacterFault::BadName { bytes: self.drawing_path.len(), limit: 4096 };
            return Err(flaw(&at, "path of the drawing", fault));
        }
        if self.drawing.segment_count() == 0 {
            return Err(flaw(&at, "the character", CharacterFault::EmptyDrawing { drawing: drawing() }));
        }
        let most = self.drawing.bounds().map_or(0.0, |(low, high)| low.abs().max(high.abs()).max_element());
        if most > FARTHEST {
            let fault = CharacterFault::FarDrawing { drawing: drawing(), limit: FARTHEST };
            return Err(flaw(&at, "the character", fault));
        }
        Ok(())
    }

    fn check_part<'a>(&'a self, number: usize, part: &'a Part, names: &mut HashSet<&'a str>) -> Result<(), Flaw> {
        let (at, element) = (vec![Step::Field("parts"), Step::Item(number)], format!("part `{}`", part.name));
        let failed = |field: &'static str, fault| {
            let mut at = at.clone();
            at.push(Step::Field(field));
            Flaw { at, element: element.clone(), fault }
        };
        check_name(&part.name).map_err(|fault| failed("name", fault))?;
        if !names.insert(&part.name) {
            return Err(failed("name", CharacterFault::SameName { what: "part" }));
        }
        if part.shapes.is_empty() {
            return Err(failed("shapes", CharacterFault::NoShapes));
        }
        if part.follows.is_empty() {
            return Err(failed("follows", CharacterFault::FollowsNothing));
        }
        let mut seen = HashSet::new();
        for joint in &part.follows {
            let name = self.joint_name(*joint).map_err(|fault| failed("follows", fault))?;
            if !seen.insert(*joint) {
                return Err(failed("follows", CharacterFault::SameJoint { name }));
            }
        }
        within("z", part.z, -FARTHEST, FARTHEST).map_err(|fault| failed("z", fault))?;
        let mut weights_at = at.clone();
        weights_at.push(Step::Field("weights"));
        match &part.weights {
            Some(own) => self.check_weights(own, Some(part), &weights_at, &element),
            // What holds for all must do for this one.
            None => self.check_weights(&self.weights, Some(part), &at, &element),
        }
    }

    fn check_weights(
        &self,
        weights: &WeightSource,
        part: Option<&Part>,
        at: &[Step],
        element: &str,
    ) -> Result<(), Flaw> {
        let failed = |fault| flaw(at, element, fault);
        let triangles_fit = |triangles: u32| {
            let [least, most] = TRIANGLES.map(f64::from);
            within("the number of triangles", f64::from(triangles), least, most).map_err(failed)
        };
        let limit = MOST_CORNERS;
        let most = |found: usize| {
            let fault = CharacterFault::TooMany { what: "corners", found, limit };
            if found <= limit { Ok(()) } else { Err(failed(fault)) }
        };
        match weights {
            WeightSource::Shepard { power } => within("the power", *power, 1.0, 8.0).map_err(failed),
            WeightSource::Bounded { triangles, outline } => {
                triangles_fit(*triangles)?;
                most(outline.len())?;
                outline.iter().try_for_each(|corner| far("a corner", *corner)).map_err(failed)
            }
            WeightSource::Cage { triangles, corners } => {
                triangles_fit(*triangles)?;
                most(corners.len())?;
                for corner in corners {
                    far("a corner", corner.at).map_err(failed)?;
                    let name = self.joint_name(corner.joint).map_err(failed)?;
                    if part.is_some_and(|part| part.follows.len() > 1 && !part.follows.contains(&corner.joint)) {
                        return Err(failed(CharacterFault::CornerElsewhere { name }));
                    }
                }
                Ok(())
            }
        }
    }

    fn joint_name(&self, joint: usize) -> Result<String, CharacterFault> {
        let found = self.joints.get(joint).map(|joint| joint.name.clone());
        found.ok_or_else(|| CharacterFault::NoSuchJoint { name: format!("#{joint}") })
    }

    fn check_joins(&self, assigned: &[Option<usize>]) -> Result<(), Flaw> {
        let mut changes = 0;
        for (number, part) in self.parts.iter().enumerate().filter(|(_, part)| !part.joins.is_empty()) {
            let mut shapes: HashMap<&str, Vec<usize>> = HashMap::new();
            for (shape, _) in assigned.iter().enumerate().filter(|(_, of)| **of == Some(number)) {
                if let Some(id) = self.drawing.shapes.get(shape).and_then(|shape| shape.id.as_deref()) {
                    shapes.entry(id).or_default().push(shape);
                }
            }
            let mut chains: HashMap<(usize, usize), Chain> = HashMap::new();
            for (place, join) in part.joins.iter().enumerate() {
                let failed = |fault| {
                    let at = [Step::Field("parts"), Step::Item(number), Step::Field("joins"), Step::Item(place)];
                    flaw(&at, &format!("part `{}`", part.name), fault)
                };
                let found = shapes.get(join.shape.as_str()).map_or(&[][..], |shapes| shapes);
                changes += found.len() + 1;
                if changes > MOST_CHANGES {
                    let (what, limit) = ("changes of joins", MOST_CHANGES);
                    return Err(failed(CharacterFault::TooMany { what, found: changes, limit }));
                }
                self.check_join(join, found, &mut chains).map_err(failed)?;
            }
        }
        Ok(())
    }

    /// Checks a change of a join on the shapes of its name; `chains` are those that were made already.
    fn check_join(
        &self,
        join: &JoinChange,
        shapes: &[usize],
        chains: &mut HashMap<(usize, usize), Chain>,
    ) -> Result<(), CharacterFault> {
        let (shape, path, anchor) = (join.shape.clone(), join.path, join.anchor);
        let no_join = || CharacterFault::NoSuchJoin { shape: join.shape.clone(), path, anchor };
        let mut is_found = false;
        for number in shapes {
            let Some(found) = self.drawing.shapes.get(*number).and_then(|shape| shape.paths.get(path)) else {
                continue;
            };
            let chain = chains.entry((*number, path)).or_insert_with(|| Chain::planar(found, &JoinRules::default()));
            let [incoming, outgoing] = chain.handles(anchor).ok_or_else(no_join)?;
            if join.kind != JoinKind::Corner && !(incoming.length() > 0.0 && outgoing.length() > 0.0) {
                return Err(CharacterFault::NoDirection { shape, path, anchor });
            }
            is_found = true;
        }
        is_found.then_some(()).ok_or_else(no_join)
    }

    fn check_cost(&self, assigned: &[Option<usize>]) -> Result<(), Flaw> {
        let (mut pairs, mut used) = (0_usize, vec![false; self.parts.len()]);
        for (shape, part) in self.drawing.shapes.iter().zip(assigned) {
            let Some((number, part)) = part.and_then(|number| Some((number, self.parts.get(number)?))) else {
                continue;
            };
            let segments: usize = shape.paths.iter().map(|path| path.segment_count()).sum();
            pairs = pairs.saturating_add(segments.saturating_mul(part.follows.len()));
            used[number] = true;
        }
        let too_costly = |what, found, limit| {
            flaw(&[Step::Field("parts")], "the character", CharacterFault::TooCostly { what, found, limit })
        };
        if pairs > MOST_PAIRS {
            return Err(too_costly("segments times joints", pairs, MOST_PAIRS));
        }
        let solved = self.parts.iter().zip(used).filter(|(part, used)| *used && part.follows.len() > 1);
        let cost = |part: &Part| self.solved_cost(part);
        let found = solved.fold(0_usize, |sum, (part, _)| sum.saturating_add(cost(part)));
        if found > MOST_SOLVED {
            return Err(too_costly("triangles times joints", found, MOST_SOLVED));
        }
        Ok(())
    }

    /// Triangles times joints of a part whose weights are solved for; a cage's corners count a tenth. Handles are vertices too: four more triangles for each.
    fn solved_cost(&self, part: &Part) -> usize {
        match self.source_of(part) {
            WeightSource::Shepard { .. } => 0,
            WeightSource::Bounded { triangles, .. } => {
                let joints: Vec<u32> = part.follows.iter().map(|joint| *joint as u32).collect();
                let ends: Vec<[DVec3; 2]> = self.handles_of(part, &joints).iter().map(HandleShape::ends).collect();
                let all = || ends.iter().flatten().copied();
                let extent = all().fold(DVec3::MIN, DVec3::max).distance(all().fold(DVec3::MAX, DVec3::min));
                // As far apart as vertices will be at least.
                let step = extent / f64::from(*triangles).sqrt();
                let places = |[from, to]: &[DVec3; 2]| 1 + (from.distance(*to) / step).min(1e6) as usize;
                let triangles = f64::from(*triangles) + 4.0 * ends.iter().map(places).sum::<usize>() as f64;
                // Solving takes more than twice as long for twice as many.
                ((triangles * (triangles / 1000.0).sqrt().max(1.0)) as usize).saturating_mul(ends.len())
            }
            WeightSource::Cage { triangles, corners } => (*triangles as usize + 4 * corners.len()) * corners.len() / 10,
        }
    }

    fn check_clip<'a>(&'a self, number: usize, clip: &'a Clip, names: &mut HashSet<&'a str>) -> Result<(), Flaw> {
        let (at, element) = (vec![Step::Field("clips"), Step::Item(number)], format!("clip `{}`", clip.name));
        let failed = |fault| flaw(&at, &element, fault);
        check_name(&clip.name).map_err(failed)?;
        if !names.insert(&clip.name) {
            return Err(failed(CharacterFault::SameName { what: "clip" }));
        }
        within("its duration", clip.duration, 1e-3, LONGEST).map_err(failed)?;
        let mut seen = HashSet::new();
        for (place, track) in clip.tracks.iter().enumerate() {
            let joint = self.joints.get(track.joint).map(|joint| joint.name.as_str());
            let (channel, name) = (track.keys.channel(), joint.unwrap_or_default());
            let element = format!("{element}, {channel} of joint `{name}`");
            let mut at = at.clone();
            at.extend([Step::Field("tracks"), Step::Item(place)]);
            let failed = |fault| flaw(&at, &element, fault);
            self.joint_name(track.joint).map_err(failed)?;
            if !seen.insert((track.joint, channel)) {
                return Err(failed(CharacterFault::SameTrack { channel, name: name.to_owned() }));
            }
            at.push(Step::Field("keys"));
            check_keys(clip, &track.keys).map_err(|(key, fault)| {
                // The keys are a list in a variant.
                at.extend(key.into_iter().flat_map(|key| [Step::Item(0), Step::Item(key)]));
                flaw(&at, &element, fault)
            })?;
        }
        Ok(())
    }
}

/// A fault of keys, and of which one if it is of one.
fn check_keys(clip: &Clip, keys: &Keys) -> Result<(), (Option<usize>, CharacterFault)> {
    if keys.is_empty() {
        return Err((None, CharacterFault::NoKeys));
    }
    let mut before = f64::NEG_INFINITY;
    for key in 0..keys.len() {
        let failed = |fault| (Some(key), fault);
        let time = keys.time(key).unwrap_or(f64::NAN);
        within("its time", time, 0.0, clip.duration).map_err(failed)?;
        if time <= before {
            return Err(failed(CharacterFault::KeyOrder { key }));
        }
        if clip.loops && time >= clip.duration {
            return Err(failed(CharacterFault::KeyAtTheEnd { key }));
        }
        before = time;
    }
    let both = |keys: &[(f64, glam::DVec2)], what, most: f64| {
        keys.iter().enumerate().try_for_each(|(key, (_, value))| {
            value.to_array().into_iter().try_for_each(|x| within(what, x, -most, most)).map_err(|f| (Some(key), f))
        })
    };
    match keys {
        Keys::Translation(keys) => both(keys, "its translation", FARTHEST),
        Keys::Scale(keys) => both(keys, "its scale", MOST_SCALE),
        Keys::Rotation(keys) => keys
            .iter()
            .enumerate()
            .try_for_each(|(key, (_, angle))| check_angle(*angle).map_err(|fault| (Some(key), fault))),
    }
}

pub(super) fn flaw(at: &[Step], element: &str, fault: CharacterFault) -> Flaw {
    Flaw { at: at.to_vec(), element: element.to_owned(), fault }
}

fn limit_count(field: &'static str, found: usize, limit: usize, what: &'static str) -> Result<(), Flaw> {
    let fault = CharacterFault::TooMany { what, found, limit };
    if found <= limit { Ok(()) } else { Err(flaw(&[Step::Field(field)], "the character", fault)) }
}

fn check_name(name: &str) -> Result<(), CharacterFault> {
    let fits = (1..=LONGEST_NAME).contains(&name.len());
    if fits { Ok(()) } else { Err(CharacterFault::BadName { bytes: name.len(), limit: LONGEST_NAME }) }
}

fn within(what: &'static str, found: f64, least: f64, most: f64) -> Result<(), CharacterFault> {
    let fits = (least..=most).contains(&found);
    if fits { Ok(()) } else { Err(CharacterFault::OutOfRange { what, found, least, most }) }
}

/// Angles that are within bounds in degrees, whatever rounding does.
fn check_angle(radians: f64) -> Result<(), CharacterFault> {
    within("its angle in degrees", radians.to_degrees(), -1.01 * MOST_DEGREES, 1.01 * MOST_DEGREES)
}

fn far(what: &'static str, place: glam::DVec2) -> Result<(), CharacterFault> {
    place.to_array().into_iter().try_for_each(|x| within(what, x, -FARTHEST, FARTHEST))
}
