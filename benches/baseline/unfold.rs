//! A strip of faces laid out in the plane.

use bevy_surface_splines::surface::SurfacePoint;
use glam::{DVec2, DVec3};

use super::mesh::Mesh;

/// A side that a strip passes through, as seen when going along it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Portal {
    pub(super) left: DVec2,
    pub(super) right: DVec2,
    pub(super) left_vertex: u32,
    pub(super) right_vertex: u32,
}

/// The sides between the faces of a strip, and its ends, in one plane.
#[derive(Clone, Debug, Default)]
pub(super) struct Unfolded {
    pub(super) start: DVec2,
    pub(super) end: DVec2,
    pub(super) portals: Vec<Portal>,
}

impl Unfolded {
    /// Lays out a strip of two faces or more; false if its faces are not neighbours.
    pub(super) fn lay_out(&mut self, mesh: &Mesh, strip: &[u32], from: &SurfacePoint, to: &SurfacePoint) -> bool {
        self.portals.clear();
        let [first, second, ..] = *strip else { return false };
        let Some([a, b]) = mesh.side_between(first, second) else { return false };
        let c = third(mesh.faces[first as usize], a, b);
        // The first face lies behind its portal, whose left end is b where a, b, c run counter-clockwise.
        let (left, right) = (DVec2::new(mesh.position(a).distance(mesh.position(b)), 0.0), DVec2::ZERO);
        let mut portal = Portal { left, right, left_vertex: b, right_vertex: a };
        let behind = ahead(mesh, &portal, c);
        let behind = DVec2::new(behind.x, -behind.y);
        self.start = combine(mesh, from, &portal, c, behind);
        self.portals.push(portal);

        for (i, &face) in strip.iter().enumerate().skip(1) {
            let tip = third(mesh.faces[face as usize], portal.left_vertex, portal.right_vertex);
            let place = ahead(mesh, &portal, tip);
            let Some(&next) = strip.get(i + 1) else {
                self.end = combine(mesh, to, &portal, tip, place);
                break;
            };
            let Some(side) = mesh.side_between(face, next) else { return false };
            if side.contains(&portal.left_vertex) {
                (portal.right, portal.right_vertex) = (place, tip);
            } else {
                (portal.left, portal.left_vertex) = (place, tip);
            }
            self.portals.push(portal);
        }
        true
    }
}

/// Where a face's third vertex lies that is entered through a portal.
fn ahead(mesh: &Mesh, portal: &Portal, tip: u32) -> DVec2 {
    let origin = mesh.position(portal.right_vertex);
    let side: DVec3 = mesh.position(portal.left_vertex) - origin;
    let to_tip = mesh.position(tip) - origin;
    let square = side.length_squared();
    if square == 0.0 {
        return portal.right;
    }
    let along = side.dot(to_tip) / square;
    let across = side.cross(to_tip).length() / square;
    let plane = portal.left - portal.right;
    portal.right + plane * along + DVec2::new(plane.y, -plane.x) * across
}

/// A point's place in the plane, by those of its face's corners.
fn combine(mesh: &Mesh, point: &SurfacePoint, portal: &Portal, tip: u32, place: DVec2) -> DVec2 {
    let corners = mesh.faces[point.face.0 as usize];
    let weighed = corners.iter().zip(point.weights).map(|(&corner, weight)| {
        let at = match corner {
            c if c == tip => place,
            c if c == portal.left_vertex => portal.left,
            _ => portal.right,
        };
        at * weight
    });
    weighed.sum()
}

/// The vertex of a face that is neither of two.
fn third(corners: [u32; 3], a: u32, b: u32) -> u32 {
    corners.into_iter().find(|&c| c != a && c != b).unwrap_or(corners[0])
}
