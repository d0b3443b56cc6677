//! Characters that follow the skeleton of a model.

use glam::{DAffine2, DAffine3, DMat2, DVec2, DVec3};

use super::{Character, CharacterError, CharacterFault};
use crate::format::SkinnedMesh;

/// The plane in space that a drawing lies in, to follow a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawingPlane {
    /// Where the drawing's origin lies.
    pub origin: DVec3,
    /// The way of one unit of the drawing to the right.
    pub x: DVec3,
    /// The way of one unit of the drawing up; at a right angle to `x`, or movements are sheared.
    pub y: DVec3,
}

impl DrawingPlane {
    /// A place of the drawing in space.
    pub fn place(&self, at: DVec2) -> DVec3 {
        self.origin + self.x * at.x + self.y * at.y
    }

    /// The place of the drawing that a place in space is seen at, by a look along the plane's normal.
    pub fn seen(&self, place: DVec3) -> DVec2 {
        let way = place - self.origin;
        DVec2::new(way.dot(self.x) / self.x.length_squared(), way.dot(self.y) / self.y.length_squared())
    }

    /// What a movement in space is, seen in the plane: where places of the plane go.
    pub fn movement(&self, transform: &DAffine3) -> DAffine2 {
        let to = |at: DVec2| self.seen(transform.transform_point3(self.place(at)));
        let origin = to(DVec2::ZERO);
        DAffine2::from_mat2_translation(DMat2::from_cols(to(DVec2::X) - origin, to(DVec2::Y) - origin), origin)
    }
}

/// Which joint of a model each joint of a character follows.
#[derive(Clone, Debug, PartialEq)]
pub struct SkeletonMap {
    joints: Vec<Option<usize>>,
}

impl SkeletonMap {
    /// Joints of a character with those of a model that they follow, both by name. Joints that are not named go with their parents.
    ///
    /// # Errors
    /// [`CharacterError::Fault`]: the character or the model has no joint of a name.
    pub fn by_names(
        character: &Character,
        model: &SkinnedMesh,
        pairs: &[(&str, &str)],
    ) -> Result<Self, CharacterError> {
        let mut joints = vec![None; character.joints.len()];
        for (own, other) in pairs {
            let missing = |whose: &str, name: &str| CharacterError::Fault {
                place: None,
                element: whose.to_owned(),
                fault: CharacterFault::NoSuchJoint { name: name.to_owned() },
            };
            let own = character.joint_named(own).ok_or_else(|| missing("the character", own))?;
            joints[own] = Some(model.joint_named(other).ok_or_else(|| missing("the model", other))?);
        }
        Ok(Self { joints })
    }

    /// From the frames of a character's joints to the drawing in a pose of the model ([`SkinnedMesh::pose`]): what
    /// [`BoundCharacter::pose`](super::BoundCharacter::pose) takes. The drawing lies in the plane as the model was bound.
    pub fn worlds(&self, character: &Character, plane: &DrawingPlane, pose: &[DAffine3], out: &mut Vec<DAffine2>) {
        out.clear();
        for (number, joint) in character.joints.iter().enumerate() {
            let followed = self.joints.get(number).copied().flatten().and_then(|joint| pose.get(joint));
            let parent = joint.parent.and_then(|parent| out.get(parent));
            out.push(match (followed, parent) {
                (Some(transform), _) => plane.movement(transform) * joint.rest_world(),
                (None, Some(parent)) => *parent * character.rest_pose(number).transform(),
                (None, None) => joint.rest_world(),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::character::tests::doll;

    #[test]
    fn movements_are_seen_along_the_normal() {
        // A hundred units a metre, in a plane that stands at x = 1 and looks along −x.
        let plane = DrawingPlane { origin: DVec3::new(1.0, 2.0, 3.0), x: DVec3::NEG_Z * 0.01, y: DVec3::Y * 0.01 };
        let at = DVec2::new(30.0, -20.0);
        assert_eq!(plane.place(at), DVec3::new(1.0, 1.8, 2.7));
        assert!(plane.seen(plane.place(at) + DVec3::X * 7.0).distance(at) < 1e-12);
        // A turn about the normal by what is seen as counter-clockwise, about a place of the drawing.
        let centre = plane.place(at);
        let turn = DAffine3::from_translation(centre)
            * DAffine3::from_axis_angle(DVec3::X, 0.5)
            * DAffine3::from_translation(-centre);
        let seen = plane.movement(&turn);
        let wished = DAffine2::from_translation(at) * DAffine2::from_angle(0.5) * DAffine2::from_translation(-at);
        assert!(seen.abs_diff_eq(wished, 1e-12), "{seen} {wished}");
        // A turn out of the plane is seen as shorter.
        let turn = DAffine3::from_axis_angle(DVec3::Y, 1.0);
        let x = plane.movement(&turn).transform_vector2(DVec2::X);
        assert!(x.distance(DVec2::X * 1.0_f64.cos()) < 1e-12, "{x}");
    }

    #[test]
    fn joints_follow_and_others_go_with_their_parents() {
        let doll = doll();
        let plane = DrawingPlane { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y };
        let map = SkeletonMap { joints: vec![Some(1), None, Some(0), None] };
        let pose = [DAffine3::from_translation(DVec3::Y * 5.0), DAffine3::from_rotation_z(0.3), DAffine3::ZERO];
        let mut worlds = Vec::new();
        map.worlds(&doll, &plane, &pose, &mut worlds);
        let turn = DAffine2::from_angle(0.3);
        for joint in [0, 1, 3] {
            assert!(worlds[joint].abs_diff_eq(turn * doll.joints[joint].rest_world(), 1e-10), "{joint}");
        }
        assert!(worlds[2].translation.distance(doll.joints[2].at + DVec2::Y * 5.0) < 1e-12);
    }
}
