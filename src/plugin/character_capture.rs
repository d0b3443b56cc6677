//! The state of living characters, to be written.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use super::character::{CharacterJoints, Instance};
use crate::character::{Character, Clip, Easing, JointPose, Keys, Track};

/// Takes down how characters are posed.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_surface_splines::plugin::{BezierCharacter, CharacterCapture};
/// fn save(capture: CharacterCapture, hero: Single<Entity, With<BezierCharacter>>) -> Result {
///     // The character of its file, with its pose as a clip.
///     let text = capture.with_pose(*hero, "greeting")?.to_ron()?;
///     std::fs::write("hero.character.ron", text)?;
///     Ok(())
/// }
/// ```
#[derive(SystemParam)]
pub struct CharacterCapture<'w, 's> {
    characters: Query<'w, 's, (&'static Instance, &'static CharacterJoints)>,
    joints: Query<'w, 's, &'static Transform>,
}

/// Why a character could not be taken down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CharacterCaptureError {
    /// It is none, or it is not there yet.
    #[error("{0} is no character that is there: wait for `CharacterReady`")]
    NoCharacter(Entity),
}

impl CharacterCapture<'_, '_> {
    /// Where the joints of a character are in the frames of their parents, as far as the plane goes; a joint that is gone is at rest.
    ///
    /// # Errors
    /// [`CharacterCaptureError`].
    pub fn pose(&self, character: Entity) -> Result<Vec<JointPose>, CharacterCaptureError> {
        let (of, joints) = self.characters.get(character).map_err(|_| CharacterCaptureError::NoCharacter(character))?;
        let pose = |(number, rest): (usize, JointPose)| {
            let transform = joints.get(number).and_then(|joint| self.joints.get(joint).ok());
            transform.map_or(rest, |transform| JointPose {
                translation: transform.translation.truncate().as_dvec2(),
                rotation: 2.0 * f64::from(transform.rotation.z).atan2(f64::from(transform.rotation.w)),
                scale: transform.scale.truncate().as_dvec2(),
            })
        };
        Ok(of.prepared.character.rest_poses().into_iter().enumerate().map(pose).collect())
    }

    /// The character of the file with the pose as a clip of some name, in which nothing moves; it takes the place of one that has the name.
    ///
    /// # Errors
    /// [`CharacterCaptureError`].
    pub fn with_pose(&self, character: Entity, clip: &str) -> Result<Character, CharacterCaptureError> {
        let pose = self.pose(character)?;
        let (of, _) = self.characters.get(character).map_err(|_| CharacterCaptureError::NoCharacter(character))?;
        // That of which it was made: the file may have changed since.
        let mut taken = Character::clone(&of.prepared.character);
        let mut tracks = Vec::new();
        for (joint, now) in pose.iter().enumerate() {
            let rest = taken.rest_pose(joint);
            let mut add = |keys| tracks.push(Track { joint, easing: Easing::Linear, keys });
            // Single precision keeps no more digits.
            let by = now.translation - rest.translation;
            if by.length() > 1e-6 * (now.translation.length() + rest.translation.length()) {
                add(Keys::Translation(vec![(0.0, by)]));
            }
            let turn = (now.rotation - rest.rotation + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI;
            if turn.abs() > 1e-6 {
                add(Keys::Rotation(vec![(0.0, turn)]));
            }
            if (now.scale - rest.scale).length() > 1e-6 {
                add(Keys::Scale(vec![(0.0, now.scale / rest.scale)]));
            }
        }
        let made = Clip { name: clip.to_owned(), duration: 1.0, loops: false, tracks };
        match taken.clips.iter_mut().find(|known| known.name == clip) {
            Some(known) => *known = made,
            None => taken.clips.push(made),
        }
        Ok(taken)
    }
}
