//! Joints, and where they are.

use glam::{DAffine2, DVec2};

use super::Character;

/// A joint of a character, as it is at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joint {
    /// Its name; no two joints have the same.
    pub name: String,
    /// The joint that carries it: always one with a smaller number.
    pub parent: Option<usize>,
    /// Where it is at rest, in the drawing.
    pub at: DVec2,
    /// The direction of its x axis at rest, in radians, counter-clockwise from the drawing's.
    pub angle: f64,
    /// Where the bone that begins at it ends at rest, in the drawing; a joint without one is a point.
    pub tip: Option<DVec2>,
}

/// Where a joint is in the frame of its parent, or of the drawing if it has none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct JointPose {
    /// Its place, in the drawing's units.
    pub translation: DVec2,
    /// Its direction, in radians, counter-clockwise.
    pub rotation: f64,
    /// By how much lengths along its axes grow.
    pub scale: DVec2,
}

impl Default for JointPose {
    fn default() -> Self {
        Self { translation: DVec2::ZERO, rotation: 0.0, scale: DVec2::ONE }
    }
}

impl JointPose {
    /// The transform to the frame of its parent.
    pub fn transform(&self) -> DAffine2 {
        DAffine2::from_scale_angle_translation(self.scale, self.rotation, self.translation)
    }
}

impl Joint {
    /// From its frame to the drawing, at rest.
    pub fn rest_world(&self) -> DAffine2 {
        DAffine2::from_angle_translation(self.angle, self.at)
    }
}

impl Character {
    /// The joint of a name.
    pub fn joint_named(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Where a joint is at rest in the frame of its parent; the origin if there is no such joint.
    pub fn rest_pose(&self, joint: usize) -> JointPose {
        let Some(own) = self.joints.get(joint) else { return JointPose::default() };
        let parent = own.parent.and_then(|parent| self.joints.get(parent));
        let (at, angle) = parent.map_or((DVec2::ZERO, 0.0), |parent| (parent.at, parent.angle));
        // Without an angle nothing is rounded but the difference.
        let turned = if angle == 0.0 { own.at - at } else { DVec2::from_angle(-angle).rotate(own.at - at) };
        JointPose { translation: turned, rotation: own.angle - angle, scale: DVec2::ONE }
    }

    /// Where all joints are at rest in the frames of their parents: what to start a pose from.
    pub fn rest_poses(&self) -> Vec<JointPose> {
        (0..self.joints.len()).map(|joint| self.rest_pose(joint)).collect()
    }

    /// From the frames of joints to the drawing, at rest.
    pub fn rest_worlds(&self) -> Vec<DAffine2> {
        self.joints.iter().map(Joint::rest_world).collect()
    }

    /// From the frames of joints to the drawing in a pose. Joints that `locals` leaves out are at rest in their parents' frames. Takes no memory
    /// once `out` has room for all joints.
    pub fn worlds(&self, locals: &[JointPose], out: &mut Vec<DAffine2>) {
        out.clear();
        for (number, joint) in self.joints.iter().enumerate() {
            let local = locals.get(number).copied().unwrap_or_else(|| self.rest_pose(number)).transform();
            // A parent comes before its children.
            let parent = joint.parent.and_then(|parent| out.get(parent)).copied();
            out.push(parent.map_or(local, |parent| parent * local));
        }
    }
}
