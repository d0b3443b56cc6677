//! Character files as assets: the drawing, the joints and the clips in one.

use std::collections::HashSet;
use std::sync::Arc;

use bevy::animation::graph::AnimationNodeIndex;
use bevy::animation::{AnimationClip, AnimationTargetId, animated_field, animation_curves::*, graph::AnimationGraph};
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext, ParseAssetPathError};
use bevy::math::curve::{Curve, Interval};
use bevy::prelude::*;

use crate::character::{Character, CharacterError, CharacterFile, DrawingFault, JointPose, Keys};

/// A character that was loaded, in files that end in `.character.ron`. All that show it share it.
///
/// Its clips are assets of their own, `hero.character.ron#clip/walk`, and so is a graph that has each of them as a node, `hero.character.ron#graph`.
/// If the file or its drawing changes, both are loaded again; a file that cannot be read leaves what is there.
#[derive(Asset, TypePath, Clone, Debug)]
pub struct CharacterAsset {
    character: Arc<Character>,
    graph: Handle<AnimationGraph>,
    clips: Vec<CharacterClip>,
}

/// A clip of a character for the engine's player.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacterClip {
    /// Its name.
    pub name: String,
    /// Its node in the character's graph: what `AnimationPlayer::play` wants.
    pub node: AnimationNodeIndex,
    /// The clip.
    pub clip: Handle<AnimationClip>,
}

impl CharacterAsset {
    /// The character.
    pub fn character(&self) -> &Arc<Character> {
        &self.character
    }

    /// The graph that has each clip as a node.
    pub fn graph(&self) -> &Handle<AnimationGraph> {
        &self.graph
    }

    /// The clips.
    pub fn clips(&self) -> &[CharacterClip] {
        &self.clips
    }

    /// The node of a clip in the graph, to be played.
    pub fn node(&self, clip: &str) -> Option<AnimationNodeIndex> {
        self.clips.iter().find(|known| known.name == clip).map(|known| known.node)
    }

    /// A character that was made by code, with its clips and its graph as assets.
    pub fn new(character: Character, clips: &mut Assets<AnimationClip>, graphs: &mut Assets<AnimationGraph>) -> Self {
        let (mut asset, graph) = Self::with_clips(character, |_, clip| clips.add(clip));
        asset.graph = graphs.add(graph);
        asset
    }

    /// The same, with a graph that is no asset yet.
    fn with_clips(
        character: Character,
        mut add: impl FnMut(&str, AnimationClip) -> Handle<AnimationClip>,
    ) -> (Self, AnimationGraph) {
        let character = Arc::new(character);
        let mut graph = AnimationGraph::new();
        let mut clips = Vec::with_capacity(character.clips.len());
        let moved = moved_by_clips(&character);
        for (number, clip) in character.clips.iter().enumerate() {
            let handle = add(&clip.name, engine_clip(&character, number, &moved));
            let node = graph.add_clip(handle.clone(), 1.0, graph.root);
            clips.push(CharacterClip { name: clip.name.clone(), node, clip: handle });
        }
        (Self { graph: Handle::default(), character, clips }, graph)
    }
}

/// What an animation of a joint is known by: the names of all joints down to it.
pub(super) fn target_of(character: &Character, joint: usize) -> AnimationTargetId {
    let mut names = Vec::new();
    let mut next = Some(joint);
    // A parent has a smaller number than its child.
    while let Some((number, joint)) = next.and_then(|number| Some((number, character.joints.get(number)?))) {
        names.push(joint.name.as_str());
        next = joint.parent.filter(|parent| *parent < number);
    }
    names.iter().rev().collect()
}

/// The transform of a joint in some pose.
pub(super) fn transform_of(pose: &JointPose) -> Transform {
    Transform {
        translation: pose.translation.as_vec2().extend(0.0),
        rotation: Quat::from_rotation_z(pose.rotation as f32),
        scale: pose.scale.as_vec2().extend(1.0),
    }
}

/// What of a joint a curve moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Channel {
    Translation,
    Rotation,
    Scale,
}

impl Channel {
    fn of(keys: &Keys) -> Self {
        match keys {
            Keys::Translation(_) => Self::Translation,
            Keys::Rotation(_) => Self::Rotation,
            Keys::Scale(_) => Self::Scale,
        }
    }
}

/// One channel of a joint in a clip, as a curve of the engine's; at rest where the clip does not move it.
#[derive(Clone, Debug, Reflect)]
#[reflect(opaque, Clone, Debug)]
struct JointCurve {
    character: Arc<Character>,
    clip: usize,
    joint: usize,
    track: Option<usize>,
}

impl JointCurve {
    fn pose(&self, time: f32) -> Transform {
        let mut pose = self.character.rest_pose(self.joint);
        if let Some(clip) = self.character.clips.get(self.clip)
            && let Some(track) = self.track.and_then(|track| clip.tracks.get(track))
        {
            clip.apply(track, f64::from(time), &mut pose);
        }
        transform_of(&pose)
    }

    fn interval(&self) -> Interval {
        let duration = self.character.clips.get(self.clip).map_or(0.0, |clip| clip.duration as f32);
        Interval::new(0.0, duration).unwrap_or(Interval::UNIT)
    }
}

/// A curve that gives translations or scales.
#[derive(Clone, Debug, Reflect)]
#[reflect(opaque, Clone, Debug)]
struct VectorCurve(JointCurve, bool);

impl Curve<Vec3> for VectorCurve {
    fn domain(&self) -> Interval {
        self.0.interval()
    }

    fn sample_unchecked(&self, t: f32) -> Vec3 {
        let pose = self.0.pose(t);
        if self.1 { pose.scale } else { pose.translation }
    }
}

/// A curve that gives rotations.
#[derive(Clone, Debug, Reflect)]
#[reflect(opaque, Clone, Debug)]
struct TurnCurve(JointCurve);

impl Curve<Quat> for TurnCurve {
    fn domain(&self) -> Interval {
        self.0.interval()
    }

    fn sample_unchecked(&self, t: f32) -> Quat {
        self.0.pose(t).rotation
    }
}

/// What any clip of a character moves.
fn moved_by_clips(character: &Character) -> Vec<(usize, Channel)> {
    let mut known = HashSet::new();
    let tracks = character.clips.iter().flat_map(|clip| &clip.tracks);
    tracks.map(|track| (track.joint, Channel::of(&track.keys))).filter(|one| known.insert(*one)).collect()
}

/// A clip for the engine's player. It moves all that any clip of the character moves, so that what this one leaves alone goes back to rest.
fn engine_clip(character: &Arc<Character>, clip: usize, moved: &[(usize, Channel)]) -> AnimationClip {
    let mut made = AnimationClip::default();
    let tracks = character.clips.get(clip).map_or(&[][..], |clip| &clip.tracks);
    for (joint, channel) in moved.iter().copied() {
        let track = tracks.iter().position(|track| track.joint == joint && Channel::of(&track.keys) == channel);
        let curve = JointCurve { character: character.clone(), clip, joint, track };
        let target = target_of(character, joint);
        match channel {
            Channel::Translation => made.add_curve_to_target(
                target,
                AnimatableCurve::new(animated_field!(Transform::translation), VectorCurve(curve, false)),
            ),
            Channel::Rotation => made.add_curve_to_target(
                target,
                AnimatableCurve::new(animated_field!(Transform::rotation), TurnCurve(curve)),
            ),
            Channel::Scale => made.add_curve_to_target(
                target,
                AnimatableCurve::new(animated_field!(Transform::scale), VectorCurve(curve, true)),
            ),
        }
    }
    made.set_duration(character.clips.get(clip).map_or(0.0, |clip| clip.duration as f32));
    made
}

/// Loads [`CharacterAsset`]s with the drawings that they name.
#[derive(TypePath, Clone, Copy, Debug, Default)]
pub struct CharacterLoader;

/// Why a character asset could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum CharacterLoadError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// It is no character, or its drawing cannot be used.
    #[error(transparent)]
    Character(#[from] CharacterError),
    /// The drawing's path is none of an asset.
    #[error("the path of the drawing, {path:?}, is none of an asset: {source}")]
    Path {
        /// The path.
        path: String,
        /// Why.
        source: ParseAssetPathError,
    },
}

impl AssetLoader for CharacterLoader {
    type Asset = CharacterAsset;
    type Settings = ();
    type Error = CharacterLoadError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &Self::Settings,
        context: &mut LoadContext<'_>,
    ) -> Result<CharacterAsset, CharacterLoadError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let file = CharacterFile::parse(&context.path().to_string(), &bytes)?;
        let relative = file.drawing_path().to_owned();
        let path = context.path().resolve_embed_str(&relative);
        let path = path.map_err(|source| CharacterLoadError::Path { path: relative, source })?;
        // Read by the context, so that the character is loaded again when its drawing changes.
        let drawing = context.read_asset_bytes(path).await;
        let drawing = drawing.map_err(|error| file.no_drawing(DrawingFault::Io(std::io::Error::other(error))))?;
        let character = file.with_drawing(&drawing)?;
        let (mut asset, graph) =
            CharacterAsset::with_clips(character, |name, clip| context.add_labeled_asset(format!("clip/{name}"), clip));
        asset.graph = context.add_labeled_asset("graph", graph);
        Ok(asset)
    }

    fn extensions(&self) -> &[&str] {
        &[Character::EXTENSION]
    }
}
