//! From text to characters.

use std::collections::HashMap;
use std::io;
use std::path::Path;

use glam::DAffine2;
use ron::extensions::Extensions;

use super::check::Flaw;
use super::error::DrawingFault;
use super::locate::{Step, find};
use super::stored::{Degrees, Spot, StoredCharacter, StoredClip, StoredKeys, StoredPart, StoredWeights};
use super::{
    CageCorner, Character, CharacterError, CharacterFault, Clip, JoinChange, Joint, Keys, Part, Place, Track,
    WeightSource,
};
use crate::format::document::{place, version_of};
use crate::format::regular::read_file;
use crate::vector::{Drawing, Shape, SvgLimits, ViewBox, import_svg_within};

/// Longer texts are not read.
pub(super) const MOST_BYTES: usize = 4 << 20;
/// Types of a character are nested less deeply.
const DEEPEST: usize = 32;
/// What a drawing may have, so that it is read in a part of a second.
const LIMITS: SvgLimits = SvgLimits {
    bytes: 16 << 20,
    depth: 200,
    elements: 50_000,
    segments: 50_000,
    attributes: 256,
    entity_bytes: 1 << 16,
    comparisons: 500_000,
};

/// The text of a character, read and not yet put together with its drawing: for those who fetch files themselves.
#[derive(Clone, Debug)]
pub struct CharacterFile {
    file: String,
    text: String,
    stored: StoredCharacter,
}

impl Character {
    /// Reads a character and its drawing from files.
    ///
    /// # Errors
    /// [`CharacterError`] names file, line and element.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, CharacterError> {
        let path = path.as_ref();
        let bytes = read_file(path, MOST_BYTES as u64 + 1);
        let bytes = bytes.map_err(|source| CharacterError::Io { path: path.to_owned(), source })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let drawing = |relative: &str| read_file(&folder.join(relative), LIMITS.bytes as u64 + 1);
        Self::parse(&path.display().to_string(), &bytes, drawing)
    }

    /// Reads a character from the bytes of its file, whose name serves for errors; `drawing` gives those of the drawing, of which the path is
    /// given as it stands in the file.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn parse(
        file: &str,
        bytes: &[u8],
        drawing: impl FnOnce(&str) -> io::Result<Vec<u8>>,
    ) -> Result<Self, CharacterError> {
        let read = CharacterFile::parse(file, bytes)?;
        let drawing = drawing(read.drawing_path()).map_err(|error| read.no_drawing(DrawingFault::Io(error)))?;
        read.with_drawing(&drawing)
    }
}

impl CharacterFile {
    /// Reads the bytes of a file, whose name serves for errors. What depends on the drawing is not checked yet.
    ///
    /// # Errors
    /// As [`Character::read`].
    pub fn parse(file: &str, bytes: &[u8]) -> Result<Self, CharacterError> {
        let at = |line: usize, column: usize| Place { file: file.to_owned(), line, column };
        if bytes.len() > MOST_BYTES {
            return Err(CharacterError::TooLarge { file: file.to_owned(), limit: MOST_BYTES });
        }
        let text = std::str::from_utf8(bytes).map_err(|error| {
            let sound = String::from_utf8_lossy(bytes.get(..error.valid_up_to()).unwrap_or_default());
            let (line, column) = place(&sound, sound.len());
            let (field, problem) = ("the character".to_owned(), "a byte here is not UTF-8".to_owned());
            CharacterError::Content { place: at(line, column), field, problem }
        })?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let no_character = |byte: usize| {
            let (line, column) = place(text, byte);
            CharacterError::NoCharacter(at(line, column))
        };
        match version_of(text) {
            Ok(found) if found > u64::from(Character::VERSION) => {
                return Err(CharacterError::NewerVersion { file: file.to_owned(), found });
            }
            Ok(0) => return Err(no_character(0)),
            Ok(_) => {}
            Err(byte) => return Err(no_character(byte)),
        }
        let options = ron::Options::default()
            .with_recursion_limit(DEEPEST)
            .without_default_extension(Extensions::all())
            .with_default_extension(Extensions::IMPLICIT_SOME);
        let failed = |error: ron::error::SpannedError, field: String| CharacterError::Content {
            place: at(error.span.end.line, error.span.end.col),
            field: if field == "." { "the character".to_owned() } else { field },
            problem: error.code.to_string(),
        };
        let whole = |error| failed(error, ".".to_owned());
        let mut ron = ron::Deserializer::from_str_with_options(text, &options).map_err(whole)?;
        let stored: StoredCharacter = serde_path_to_error::deserialize(&mut ron).map_err(|error| {
            let field = error.path().to_string();
            failed(ron.span_error(error.into_inner()), field)
        })?;
        ron.end().map_err(|error| whole(ron.span_error(error)))?;
        Ok(Self { file: file.to_owned(), text: text.to_owned(), stored })
    }

    /// Where the drawing lies, seen from the file.
    pub fn drawing_path(&self) -> &str {
        &self.stored.drawing
    }

    /// The error of a drawing that cannot be had, with its place in the file.
    pub fn no_drawing(&self, source: DrawingFault) -> CharacterError {
        let place = self.place(&[Step::Field("drawing")]);
        CharacterError::Drawing { place, drawing: self.stored.drawing.clone(), source }
    }

    /// Puts a character together with the bytes of its drawing.
    ///
    /// # Errors
    /// As [`Character::read`].
    pub fn with_drawing(&self, drawing: &[u8]) -> Result<Character, CharacterError> {
        let located = |flaw: Flaw| CharacterError::Fault {
            place: Some(self.place(&flaw.at)),
            element: flaw.element,
            fault: flaw.fault,
        };
        let (joints, order) = joints_of(&self.stored).map_err(located)?;
        let import = import_svg_within(drawing, &LIMITS).map_err(|error| self.no_drawing(error.into()))?;
        let character = Character {
            name: self.stored.name.clone(),
            drawing_path: self.stored.drawing.clone(),
            drawing: turned_over(import.drawing),
            joints,
            ..Character::default()
        };
        let naming = Naming::new(&character);
        let character = naming.fill(character, &self.stored).map_err(located)?;
        character.find_flaw().map(|_| ()).map_err(|mut flaw| {
            // Joints may stand in another order in the file.
            if let [Step::Field("joints"), Step::Item(joint), ..] = &mut flaw.at[..] {
                *joint = order.get(*joint).copied().unwrap_or(*joint);
            }
            located(flaw)
        })?;
        Ok(character)
    }

    fn place(&self, steps: &[Step]) -> Place {
        let (line, column) = place(&self.text, find(&self.text, steps));
        Place { file: self.file.clone(), line, column }
    }
}

/// Joints with parents first, else in the order of the file; and which of the file's each one is.
fn joints_of(stored: &StoredCharacter) -> Result<(Vec<Joint>, Vec<usize>), Flaw> {
    let list = &stored.joints;
    let flaw = |joint: usize, fault| {
        let element = format!("joint `{}`", list.get(joint).map_or("", |joint| &joint.name));
        Flaw { at: vec![Step::Field("joints"), Step::Item(joint)], element, fault }
    };
    let limit = Character::MOST_JOINTS;
    if list.len() > limit {
        let fault = CharacterFault::TooMany { what: "joints", found: list.len(), limit };
        return Err(Flaw { at: vec![Step::Field("joints")], element: "the character".to_owned(), fault });
    }
    let mut named = HashMap::new();
    for (number, joint) in list.iter().enumerate() {
        if named.insert(&joint.name, number).is_some() {
            return Err(flaw(number, CharacterFault::SameName { what: "joint" }));
        }
    }
    let mut parents = Vec::with_capacity(list.len());
    for (number, joint) in list.iter().enumerate() {
        let parent = joint.parent.as_ref().map(|name| {
            let found = named.get(name).copied();
            found.ok_or_else(|| flaw(number, CharacterFault::NoSuchJoint { name: name.clone() }))
        });
        parents.push(parent.transpose()?);
    }
    let mut places: Vec<Option<usize>> = vec![None; list.len()];
    let mut order: Vec<usize> = Vec::with_capacity(list.len());
    for start in 0..list.len() {
        let mut waiting = Vec::new();
        let mut at = Some(start);
        while let Some(joint) = at.filter(|joint| places[*joint].is_none()) {
            if let Some(first) = waiting.iter().position(|other| *other == joint) {
                let circle = waiting[first..].iter().chain([&joint]);
                let names = circle.map(|joint| list[*joint].name.clone()).collect();
                return Err(flaw(joint, CharacterFault::Cycle { names }));
            }
            waiting.push(joint);
            at = parents[joint];
        }
        for joint in waiting.into_iter().rev() {
            places[joint] = Some(order.len());
            order.push(joint);
        }
    }
    let joints = order.iter().map(|number| {
        let joint = &list[*number];
        Joint {
            name: joint.name.clone(),
            parent: parents[*number].and_then(|parent| places[parent]),
            at: Spot::flipped(joint.at.0),
            angle: joint.angle.0.to_radians(),
            tip: joint.tip.map(|tip| Spot::flipped(tip.0)),
        }
    });
    Ok((joints.collect(), order))
}

/// Numbers of joints by their names.
struct Naming(HashMap<String, usize>);

impl Naming {
    fn new(character: &Character) -> Self {
        Self(character.joints.iter().enumerate().map(|(number, joint)| (joint.name.clone(), number)).collect())
    }

    fn fill(&self, mut character: Character, stored: &StoredCharacter) -> Result<Character, Flaw> {
        let whole = || ("weights of all parts".to_owned(), vec![Step::Field("weights")]);
        character.weights = self.weights(&stored.weights, &whole)?;
        let parts = stored.parts.iter().enumerate().map(|(number, part)| self.part(number, part));
        character.parts = parts.collect::<Result<_, _>>()?;
        let clips = stored.clips.iter().enumerate().map(|(number, clip)| self.clip(number, clip));
        character.clips = clips.collect::<Result<_, _>>()?;
        Ok(character)
    }

    fn joint(&self, name: &str, element: &dyn Fn() -> (String, Vec<Step>)) -> Result<usize, Flaw> {
        self.0.get(name).copied().ok_or_else(|| {
            let (element, at) = element();
            Flaw { at, element, fault: CharacterFault::NoSuchJoint { name: name.to_owned() } }
        })
    }

    fn weights(&self, stored: &StoredWeights, element: &dyn Fn() -> (String, Vec<Step>)) -> Result<WeightSource, Flaw> {
        Ok(match stored {
            StoredWeights::Shepard { power } => WeightSource::Shepard { power: power.0 },
            StoredWeights::Bounded { triangles, outline } => WeightSource::Bounded {
                triangles: triangles.0,
                outline: outline.iter().map(|corner| Spot::flipped(corner.0)).collect(),
            },
            StoredWeights::Cage { triangles, corners } => {
                let corner = |(name, at): &(String, Spot)| {
                    Ok(CageCorner { joint: self.joint(name, element)?, at: Spot::flipped(at.0) })
                };
                let corners = corners.iter().map(corner).collect::<Result<_, Flaw>>()?;
                WeightSource::Cage { triangles: triangles.0, corners }
            }
        })
    }

    fn part(&self, number: usize, stored: &StoredPart) -> Result<Part, Flaw> {
        let at = |field| vec![Step::Field("parts"), Step::Item(number), Step::Field(field)];
        let element = || format!("part `{}`", stored.name);
        let follows = stored.follows.iter().enumerate().map(|(place, name)| {
            self.joint(name, &|| {
                let mut at = at("follows");
                at.push(Step::Item(place));
                (element(), at)
            })
        });
        let follows = follows.collect::<Result<_, _>>()?;
        let weights = stored.weights.as_ref().map(|own| self.weights(own, &|| (element(), at("weights"))));
        let joins = stored.joins.iter().map(|join| JoinChange {
            shape: join.shape.clone(),
            path: join.path as usize,
            anchor: join.anchor as usize,
            kind: join.kind,
        });
        Ok(Part {
            name: stored.name.clone(),
            shapes: stored.shapes.clone(),
            follows,
            z: stored.z.0,
            weights: weights.transpose()?,
            joins: joins.collect(),
        })
    }

    fn clip(&self, number: usize, stored: &StoredClip) -> Result<Clip, Flaw> {
        let tracks = stored.tracks.iter().enumerate().map(|(place, track)| {
            let joint = self.joint(&track.joint, &|| {
                let mut at = vec![Step::Field("clips"), Step::Item(number), Step::Field("tracks"), Step::Item(place)];
                at.push(Step::Field("joint"));
                (format!("clip `{}`, track {place}", stored.name), at)
            })?;
            let keys = match &track.keys {
                StoredKeys::Translation(keys) => {
                    Keys::Translation(keys.iter().map(|(time, by)| (time.0, Spot::flipped(by.0))).collect())
                }
                StoredKeys::Rotation(keys) => {
                    Keys::Rotation(keys.iter().map(|(time, Degrees(by))| (time.0, by.to_radians())).collect())
                }
                StoredKeys::Scale(keys) => Keys::Scale(keys.iter().map(|(time, by)| (time.0, by.0)).collect()),
            };
            Ok(Track { joint, easing: track.easing, keys })
        });
        let tracks = tracks.collect::<Result<_, Flaw>>()?;
        Ok(Clip { name: stored.name.clone(), duration: stored.duration.0, loops: stored.loops, tracks })
    }
}

/// The drawing with y up.
fn turned_over(drawing: Drawing) -> Drawing {
    let flip = DAffine2::from_scale(glam::DVec2::new(1.0, -1.0));
    let turned = |shape: Shape| {
        // What is finite stays so.
        let paths = shape.paths.iter().filter_map(|path| path.transformed(&flip)).collect();
        let mut style = shape.style;
        let stroke = style.stroke.as_mut().map(|stroke| &mut stroke.paint);
        for paint in style.fill.as_mut().into_iter().chain(stroke) {
            if let crate::vector::Paint::Gradient { to_drawing, .. } = paint {
                *to_drawing = flip * *to_drawing;
            }
        }
        Shape { paths, style, ..shape }
    };
    let view_box = drawing
        .view_box
        .map(|view| ViewBox { min: glam::DVec2::new(view.min.x, 0.0 - view.min.y - view.size.y), size: view.size });
    Drawing { view_box, shapes: drawing.shapes.into_iter().map(turned).collect(), ..drawing }
}
