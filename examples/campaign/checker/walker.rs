//! Paths that are locally shortest by construction, to try the checker on: straight lines across faces laid flat one
//! after the other, and lines drawn on a flat mesh.

use glam::{DVec2, DVec3};

use super::{Stretch, topology::Topology};

/// Walks straight ahead from a point of a face, `heading` radians from the face's first side, and stops early at the
/// boundary. The orientation of neighbours must agree.
pub(crate) fn walk(topology: &Topology, face: u32, weights: [f64; 3], heading: f64, distance: f64) -> Vec<Stretch> {
    let lengths = |face: u32| {
        let [a, b, c] = topology.places(face);
        [a.distance(b), b.distance(c), c.distance(a)]
    };
    let third = |a: DVec2, b: DVec2, la: f64, lb: f64| {
        let l = a.distance(b);
        let x = (la * la - lb * lb + l * l) / (2.0 * l);
        let u = (b - a) / l;
        a + u * x + u.perp() * (la * la - x * x).max(0.0).sqrt()
    };
    let [ab, bc, ca] = lengths(face);
    let (a, b) = (DVec2::ZERO, DVec2::new(ab, 0.0));
    let mut flat = [a, b, third(a, b, ca, bc)];
    let origin = flat[0] * weights[0] + flat[1] * weights[1] + flat[2] * weights[2];
    let direction = DVec2::from_angle(heading);
    let (mut face, mut from, mut entered) = (face, weights, None);
    let mut path = Vec::new();
    loop {
        let exit = (0..3).filter(|k| Some(*k) != entered).filter_map(|k| {
            let (a, e) = (flat[k], flat[(k + 1) % 3] - flat[k]);
            // Outwards only: the face lies on the left of its sides.
            let down = direction.perp_dot(e);
            let share = (a - origin).perp_dot(direction) / down;
            (down > 0.0 && (0.0..=1.0).contains(&share)).then(|| (k, share, (a - origin).perp_dot(e) / down))
        });
        let Some((k, share, reached)) = exit.min_by(|x, y| x.2.total_cmp(&y.2)) else { return path };
        if reached >= distance {
            path.push(Stretch { face, from, to: weights_of(&flat, origin + direction * distance) });
            return path;
        }
        let mut to = [0.0; 3];
        (to[k], to[(k + 1) % 3]) = (1.0 - share, share);
        path.push(Stretch { face, from, to });
        let Some((next, side)) = topology.across(face, k) else { return path };
        let (a, b) = (flat[(k + 1) % 3], flat[k]);
        let l = lengths(next);
        (flat[side], flat[(side + 1) % 3]) = (a, b);
        flat[(side + 2) % 3] = third(a, b, l[(side + 2) % 3], l[(side + 1) % 3]);
        from = [0.0; 3];
        (from[side], from[(side + 1) % 3]) = (share, 1.0 - share);
        (face, entered) = (next, Some(side));
    }
}

fn weights_of(flat: &[DVec2; 3], p: DVec2) -> [f64; 3] {
    let [a, b, c] = *flat;
    let whole = (b - a).perp_dot(c - a);
    let (u, v) = ((p - a).perp_dot(c - a) / whole, (b - a).perp_dot(p - a) / whole);
    [1.0 - u - v, u, v]
}

/// A polyline drawn on a mesh that lies in the plane z = 0, cut into stretches. Where it runs along a side it stays in the face
/// it came through, or takes any.
pub(crate) fn draw(topology: &Topology, corners: &[DVec2]) -> Vec<Stretch> {
    let flat = |face: u32| topology.places(face).map(DVec3::truncate);
    let faces = 0..topology.corners.len() as u32;
    let mut path: Vec<Stretch> = Vec::new();
    for leg in corners.windows(2) {
        let (origin, d) = (leg[0], leg[1] - leg[0]);
        let mut cuts = vec![0.0, 1.0];
        for face in faces.clone() {
            let t = flat(face);
            for k in 0..3 {
                let (a, e) = (t[k], t[(k + 1) % 3] - t[k]);
                let (across, along) = (d.perp_dot(e), (a - origin).perp_dot(d));
                let (cut, share) = ((a - origin).perp_dot(e) / across, along / across);
                if across.abs() > 1e-12 && (-1e-12..=1.0 + 1e-12).contains(&share) && (0.0..=1.0).contains(&cut) {
                    cuts.push(cut);
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        cuts.dedup_by(|a, b| *a - *b < 1e-12);
        for piece in cuts.windows(2) {
            let middle = origin + d * ((piece[0] + piece[1]) / 2.0);
            let holds = |face: u32| weights_of(&flat(face), middle).iter().all(|w| *w > -1e-12);
            let last = path.last().map(|s| s.face).filter(|f| holds(*f));
            let face = last.or_else(|| faces.clone().find(|f| holds(*f))).expect("the line lies on the mesh");
            let at =
                |cut: f64| weights_of(&flat(face), origin + d * cut).map(|w| if w.abs() < 1e-14 { 0.0 } else { w });
            path.push(Stretch { face, from: at(piece[0]), to: at(piece[1]) });
        }
    }
    path
}
