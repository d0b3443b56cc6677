use glam::{DVec2, Vec2, Vec3};

use super::*;
use crate::vector::{
    Color, FillRule, Gradient, GradientKind, GradientStop, LineCap, LineJoin, Paint, PathBuilder, SpatialPath,
    SpreadMethod, Stroke, Style, VectorPath,
};

/// Small, seeded random numbers (splitmix64), from −1 to 1.
struct Random(u64);

impl Random {
    fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn place(&mut self, reach: f64) -> DVec2 {
        DVec2::new(self.signed(), self.signed()) * reach
    }
}

fn circle(centre: DVec2, radius: f64, clockwise: bool) -> VectorPath {
    let mut pen = PathBuilder::default();
    let (a, b) = (centre + DVec2::X * radius, centre - DVec2::X * radius);
    pen.move_to(a);
    for to in [b, a] {
        pen.arc_to(DVec2::splat(radius), 0.0, false, !clockwise, to);
    }
    pen.close();
    pen.finish().remove(0)
}

fn filled(rule: FillRule) -> Style {
    Style { fill: Some(Paint::Color(Color::BLACK)), fill_rule: rule, stroke: None, opacity: 1.0 }
}

fn stroked(width: f64, cap: LineCap, join: LineJoin, dashes: &[f64]) -> Style {
    let paint = Paint::Color(Color { red: 1.0, ..Color::BLACK });
    let stroke = Stroke { paint, width, cap, join, miter_limit: 4.0, dashes: dashes.to_vec(), dash_offset: 0.0 };
    Style { fill: None, stroke: Some(stroke), opacity: 1.0, ..Style::default() }
}

fn picture(paths: &[VectorPath], style: &Style) -> Picture {
    Picture::planar([(paths, style)], &[], &PictureOptions::default())
}

fn made(picture: &Picture, points: &PicturePoints) -> PictureMesh {
    let mut mesh = PictureMesh::default();
    mesh.update(picture, points, &mut Tessellator::default());
    mesh
}

fn corners(mesh: &PictureMesh) -> impl Iterator<Item = [Vec2; 3]> {
    let place = |i: u32| Vec3::from_array(mesh.positions[i as usize]).truncate();
    mesh.indices.chunks_exact(3).map(move |t| [place(t[0]), place(t[1]), place(t[2])])
}

fn area(mesh: &PictureMesh) -> f64 {
    corners(mesh).map(|[a, b, c]| 0.5 * f64::from((b - a).perp_dot(c - a)).abs()).sum()
}

/// Whether a place is in one of the triangles, and by how much it misses the nearest edge of any.
fn covered(mesh: &PictureMesh, p: Vec2) -> (bool, f32) {
    let mut inside = false;
    let mut near = f32::INFINITY;
    for [a, b, c] in corners(mesh) {
        let sides = [(a, b), (b, c), (c, a)].map(|(a, b)| (b - a).perp_dot(p - a));
        inside |= sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
        for (a, b) in [(a, b), (b, c), (c, a)] {
            let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
            near = near.min(p.distance(a.lerp(b, t)));
        }
    }
    (inside, near)
}

/// Points along a path, many a segment.
fn dense(points: &[Vec3], closed: bool) -> Vec<Vec2> {
    let flat: Vec<DVec2> = points.iter().map(|p| p.truncate().as_dvec2()).collect();
    let path = VectorPath::from_points(flat, closed).unwrap();
    let all = (0..path.segment_count()).flat_map(|i| (0..200).map(move |k| (i, f64::from(k) / 200.0)));
    let mut all: Vec<Vec2> = all.map(|(i, t)| path.point_at(i, t).as_vec2()).collect();
    all.push(if closed { all[0] } else { points[points.len() - 1].truncate() });
    all
}

/// How often some outlines wind around a place.
fn winding(outlines: &[Vec<Vec2>], p: Vec2) -> i32 {
    let mut sum = 0;
    for outline in outlines {
        for (a, b) in outline.iter().zip(outline.iter().cycle().skip(1)) {
            let left = (*b - *a).perp_dot(p - *a) > 0.0;
            if a.y <= p.y && b.y > p.y && left {
                sum += 1;
            } else if a.y > p.y && b.y <= p.y && !left {
                sum -= 1;
            }
        }
    }
    sum
}

fn distance(outlines: &[Vec<Vec2>], p: Vec2) -> f32 {
    let pairs = outlines.iter().flat_map(|outline| outline.windows(2));
    let far = |pair: &[Vec2]| {
        let (a, b) = (pair[0], pair[1]);
        let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-30)).clamp(0.0, 1.0);
        p.distance(a.lerp(b, t))
    };
    pairs.map(far).fold(f32::INFINITY, f32::min)
}

/// Whether what is painted is what winding numbers say, at places that are not on the outline.
fn check_coverage(mesh: &PictureMesh, points: &PicturePoints, closed: bool, rule: FillRule, slack: f32, seed: u64) {
    let outlines: Vec<Vec<Vec2>> = (0..points.path_count()).map(|path| dense(points.of(path), closed)).collect();
    let [low, high] = mesh.bounds().unwrap();
    let mut random = Random(seed);
    for _ in 0..300 {
        let share = 0.5 * (random.place(1.1).as_vec2() + Vec2::ONE);
        let p = low.truncate() + (high - low).truncate() * share;
        if distance(&outlines, p) < slack {
            continue;
        }
        let turns = winding(&outlines, p);
        let wanted = if rule == FillRule::NonZero { turns != 0 } else { turns % 2 != 0 };
        assert_eq!(covered(mesh, p).0, wanted, "seed {seed}: {p} is wound around {turns} times");
    }
}

#[test]
fn a_disc_with_a_hole_has_its_area() {
    let paths = [circle(DVec2::ZERO, 10.0, false), circle(DVec2::X * 2.0, 4.0, true)];
    for (rule, hole) in [(FillRule::NonZero, true), (FillRule::EvenOdd, true), (FillRule::NonZero, false)] {
        let inner = if hole { paths[1].clone() } else { circle(DVec2::X * 2.0, 4.0, false) };
        let picture = picture(&[paths[0].clone(), inner], &filled(rule));
        let mesh = made(&picture, &picture.points());
        let wanted = std::f64::consts::PI * (100.0 - if hole { 16.0 } else { 0.0 });
        assert!((area(&mesh) - wanted).abs() < 2e-3 * wanted, "{rule:?}: {} of {wanted}", area(&mesh));
        check_coverage(&mesh, &picture.points(), true, rule, 0.05, 1);
        let [low, high] = mesh.bounds().unwrap();
        assert!(low.distance(Vec3::new(-10.0, -10.0, 0.0)) < 0.02 && high.distance(Vec3::new(10.0, 10.0, 0.0)) < 0.02);
    }
}

#[test]
fn random_outlines_are_filled_by_both_rules() {
    for seed in 0..40 {
        let mut random = Random(seed);
        let count = 3 * (2 + seed as usize % 6);
        let paths: Vec<VectorPath> = (0..1 + seed % 2)
            .map(|_| VectorPath::from_points((0..count).map(|_| random.place(10.0)).collect(), true).unwrap())
            .collect();
        for rule in [FillRule::NonZero, FillRule::EvenOdd] {
            let picture = picture(&paths, &filled(rule));
            check_coverage(&made(&picture, &picture.points()), &picture.points(), true, rule, 0.1, seed);
        }
    }
}

#[test]
fn moved_fills_keep_triangles_only_where_that_is_right() {
    let (mut kept, mut anew) = (0, 0);
    for seed in 0..20 {
        let mut random = Random(100 + seed);
        let paths = [circle(DVec2::ZERO, 10.0, false), circle(DVec2::X * 2.0, 4.0, true)];
        let picture = picture(&paths, &filled(FillRule::NonZero));
        let (mut points, mut mesh, mut tessellator) =
            (picture.points(), PictureMesh::default(), Tessellator::default());
        mesh.update(&picture, &points, &mut tessellator);
        for step in 0..12 {
            // Poses come near to one another, or not.
            let reach = if step % 3 == 0 { 0.5 } else { 0.02 };
            for path in 0..2 {
                let mut by = |p: &Vec3| *p + random.place(reach).as_vec2().extend(0.0);
                let by: Vec<Vec3> = points.of(path).iter().map(&mut by).collect();
                assert!(points.set(path, by));
            }
            let change = mesh.update(&picture, &points, &mut tessellator);
            assert_eq!((change.paths, change.filled + change.kept), (2, 1));
            (kept, anew) = (kept + change.kept, anew + change.filled);
            check_coverage(&mesh, &points, true, FillRule::NonZero, 0.1, 1000 * seed + step);
        }
    }
    println!("{kept} kept, {anew} anew");
    assert!(kept > 50 && anew > 5, "{kept} kept, {anew} anew");
}

#[test]
fn strokes_cover_what_is_near_their_path() {
    for seed in 0..10 {
        let mut random = Random(200 + seed);
        let points: Vec<DVec2> = (0..10).map(|_| random.place(10.0)).collect();
        let path = VectorPath::from_points(points, false).unwrap();
        let picture = picture(std::slice::from_ref(&path), &stroked(1.0, LineCap::Round, LineJoin::Round, &[]));
        let mesh = made(&picture, &picture.points());
        let outline = [dense(picture.points().of(0), false)];
        for _ in 0..400 {
            let p = random.place(11.0).as_vec2();
            let far = distance(&outline, p);
            if (far - 0.5).abs() > 0.06 {
                assert_eq!(covered(&mesh, p).0, far < 0.5, "seed {}: {p} is {far} away", 200 + seed);
            }
        }
    }
}

#[test]
fn caps_joins_and_dashes_are_as_long_as_they_should_be() {
    let mut pen = PathBuilder::default();
    pen.move_to(DVec2::ZERO);
    pen.line_to(DVec2::new(10.0, 0.0));
    pen.line_to(DVec2::new(10.0, 10.0));
    let path = pen.finish();
    let of = |cap, join, dashes: &[f64]| {
        let picture = picture(&path, &stroked(2.0, cap, join, dashes));
        let mesh = made(&picture, &picture.points());
        let grid = (-60..=240).flat_map(|i| (-60..=240).map(move |k| Vec2::new(i as f32, k as f32) / 20.0 + 0.0123));
        grid.filter(|p| covered(&mesh, *p).0).count() as f64 / 400.0
    };
    let (bare, pi) = (39.0, std::f64::consts::PI);
    for (cap, join, wanted) in [
        (LineCap::Butt, LineJoin::Miter, bare + 1.0),
        (LineCap::Butt, LineJoin::Bevel, bare + 0.5),
        (LineCap::Butt, LineJoin::Round, bare + pi / 4.0),
        (LineCap::Square, LineJoin::Miter, bare + 5.0),
        (LineCap::Round, LineJoin::Miter, bare + 1.0 + pi),
    ] {
        let found = of(cap, join, &[]);
        assert!((found - wanted).abs() < 0.15, "{cap:?}, {join:?}: {found} instead of {wanted}");
    }
    // Five dashes of two, one of which goes around the corner.
    let found = of(LineCap::Butt, LineJoin::Miter, &[2.0, 2.0]);
    assert!((found - 20.0).abs() < 0.15, "{found}");
}

#[test]
fn only_shapes_that_moved_are_made_again_and_nothing_grows() {
    let disc = |x: f64| vec![circle(DVec2::X * x, 1.0, false)];
    let (a, b, c) = (disc(0.0), disc(3.0), disc(6.0));
    let (fill, line) = (filled(FillRule::NonZero), stroked(0.2, LineCap::Butt, LineJoin::Round, &[]));
    let both = Style { stroke: line.stroke.clone(), ..fill.clone() };
    let shapes = [(&a[..], &fill), (&b[..], &both), (&c[..], &line)];
    let picture = Picture::planar(shapes, &[], &PictureOptions { layer: 0.5, ..PictureOptions::default() });
    let (mut points, mut mesh, mut tessellator) = (picture.points(), PictureMesh::default(), Tessellator::default());
    let first = mesh.update(&picture, &points, &mut tessellator);
    assert_eq!(first, PictureChange { paths: 3, filled: 2, kept: 0, stroked: 2 });
    assert_eq!(mesh.update(&picture, &points, &mut tessellator), PictureChange::default());
    let layer = |shape: usize| mesh.positions[mesh.vertices_of(shape).start][2];
    assert_eq!([layer(0), layer(1), layer(2)], [0.0, 0.5, 1.0]);
    let mut capacity = 0;
    for step in 0..1000 {
        let angle = step as f32 * 0.1;
        let squeeze = |p: &Vec3| Vec3::new(p.x, p.y * (1.0 + 0.7 * angle.sin()), 0.0);
        let rest: Vec<Vec3> = picture.rest_of(1).iter().map(squeeze).collect();
        let expected = points.moved(1) + u32::from(points.of(1) != rest);
        points.set(1, rest);
        assert_eq!([points.moved(0), points.moved(1), points.moved(2)], [0, expected, 0]);
        let change = mesh.update(&picture, &points, &mut tessellator);
        assert_eq!((change.paths, change.stroked), (u32::from(step > 0), u32::from(step > 0)));
        // As a mesh that never was another.
        if step % 100 == 0 {
            let fresh = made(&picture, &points);
            assert!((area(&mesh) - area(&fresh)).abs() < 0.02, "{} {}", area(&mesh), area(&fresh));
            assert_eq!(mesh.vertices_of(2).end, mesh.positions.len());
        }
        if step == 200 {
            capacity = mesh.capacity();
        }
    }
    assert_eq!(mesh.capacity(), capacity, "no list grows");
}

#[test]
fn gradients_colour_vertices_where_the_drawing_was() {
    let stop = |offset, red| GradientStop { offset, color: Color { red, ..Color::BLACK } };
    for kind in [
        GradientKind::Linear { from: DVec2::new(-5.0, 0.0), to: DVec2::new(5.0, 0.0) },
        GradientKind::Radial { centre: DVec2::ZERO, radius: 5.0, focus: DVec2::ZERO, focus_radius: 0.0 },
    ] {
        let stops = [stop(0.0, 0.0), stop(1.0, 1.0)].into();
        let gradient = Gradient { id: None, kind, stops, spread: SpreadMethod::Pad, of_bounds: false };
        let paint = Paint::Gradient { index: 0, to_drawing: glam::DAffine2::IDENTITY, opacity: 1.0 };
        let style = Style { fill: Some(paint), opacity: 1.0, ..Style::default() };
        let paths = [circle(DVec2::ZERO, 5.0, false)];
        let picture = Picture::planar([(&paths[..], &style)], &[gradient], &PictureOptions::default());
        let mut points = picture.points();
        let (mut mesh, mut tessellator) = (PictureMesh::default(), Tessellator::default());
        mesh.update(&picture, &points, &mut tessellator);
        let before = mesh.colors.clone();
        for (position, color) in mesh.positions.iter().zip(&mesh.colors) {
            let p = Vec3::from_array(*position);
            let wanted = match kind {
                GradientKind::Linear { .. } => 0.1 * (p.x + 5.0),
                GradientKind::Radial { .. } => p.length() / 5.0,
            };
            let red = if color[0] <= 0.003_130_8 { color[0] * 12.92 } else { 1.055 * color[0].powf(1.0 / 2.4) - 0.055 };
            assert!((red - wanted.clamp(0.0, 1.0)).abs() < 2e-3, "{p}: {red} instead of {wanted}");
        }
        assert!(mesh.positions.iter().any(|p| Vec3::from_array(*p).length() < 2.0), "there are vertices inside");
        // Colours stay with what they were drawn on.
        let aside: Vec<Vec3> = points.of(0).iter().map(|p| *p + Vec3::new(30.0, 1.0, 0.0)).collect();
        points.set(0, aside);
        mesh.update(&picture, &points, &mut tessellator);
        assert_eq!(mesh.colors, before);
    }
}

#[test]
fn edges_are_as_short_as_they_should_be_and_meet() {
    let paths = [circle(DVec2::ZERO, 10.0, false), circle(DVec2::X * 2.0, 4.0, true)];
    let style = Style { stroke: stroked(0.5, LineCap::Butt, LineJoin::Round, &[]).stroke, ..filled(FillRule::NonZero) };
    let options = PictureOptions { spacing: Some(0.8), ..PictureOptions::default() };
    let picture = Picture::planar([(&paths[..], &style)], &[], &options);
    let mut points = picture.points();
    let mut mesh = PictureMesh::default();
    mesh.update(&picture, &points, &mut Tessellator::default());
    let longest = |mesh: &PictureMesh| {
        corners(mesh).flat_map(|[a, b, c]| [a.distance(b), b.distance(c), c.distance(a)]).fold(0.0, f32::max)
    };
    assert!(longest(&mesh) < 1.01, "{}", longest(&mesh));
    let place = |mesh: &PictureMesh, i: u32| Vec3::from_array(mesh.positions[i as usize]).truncate();
    // Every edge inside is an edge of two triangles, by place; others are on the outline.
    let mut edges = std::collections::HashMap::new();
    let fill = mesh.indices.chunks_exact(3).take_while(|t| mesh.colors[t[0] as usize] == mesh.colors[0]);
    let key = |p: Vec2| (p * 1e4).round().as_ivec2();
    for t in fill {
        for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
            let (a, b) = (place(&mesh, a), place(&mesh, b));
            let (k, l) = (key(a), key(b));
            let middle = 0.5 * (a + b);
            let entry = if (k.x, k.y) < (l.x, l.y) { (k, l) } else { (l, k) };
            edges.entry(entry).or_insert((0, middle)).0 += 1;
        }
    }
    for (count, middle) in edges.values() {
        let on_rim = (middle.length() - 10.0).abs().min((middle.distance(Vec2::X * 2.0) - 4.0).abs()) < 0.05;
        assert!(*count == 2 || *count == 1 && on_rim, "{count} triangles at {middle}");
    }
    // What is moved keeps its parts.
    for path in 0..2 {
        let by: Vec<Vec3> = points.of(path).iter().map(|p| Vec3::new(1.1 * p.x, p.y, 0.0)).collect();
        points.set(path, by);
    }
    let change = mesh.update(&picture, &points, &mut Tessellator::default());
    assert_eq!((change.kept, change.filled), (1, 0));
    check_coverage(&mesh, &points, true, FillRule::NonZero, 0.4, 3);
}

#[test]
fn shapes_in_space_lie_in_their_plane() {
    let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.7, -0.4, 1.0);
    let flat = circle(DVec2::ZERO, 3.0, false);
    let placed = |p: &DVec2| (turn * p.as_vec2().extend(0.0) + Vec3::new(1.0, 2.0, 3.0)).as_dvec3();
    let path = SpatialPath::from_points(flat.points().iter().map(placed).collect(), true).unwrap();
    let style = Style { stroke: stroked(0.5, LineCap::Butt, LineJoin::Round, &[]).stroke, ..filled(FillRule::NonZero) };
    let picture = Picture::spatial([(&[path][..], &style)], &[], &PictureOptions::default());
    let mesh = made(&picture, &picture.points());
    let normal = turn * Vec3::Z;
    let off = |p: &[f32; 3]| (Vec3::from_array(*p) - Vec3::new(1.0, 2.0, 3.0)).dot(normal).abs();
    assert!(mesh.positions.iter().all(|p| off(p) < 1e-4));
    let far = |p: &[f32; 3]| Vec3::from_array(*p).distance(Vec3::new(1.0, 2.0, 3.0));
    let furthest = mesh.positions.iter().map(far).fold(0.0, f32::max);
    assert!((furthest - 3.25).abs() < 0.01, "{furthest}");
}

#[test]
fn nothing_that_is_fed_in_panics() {
    let mut random = Random(7);
    for round in 0..200 {
        let scale = 10.0_f64.powf(12.0 * random.signed());
        let count = 3 * (1 + round % 4);
        let flat = round % 3 == 0;
        let place = |r: &mut Random| if flat { DVec2::new(r.signed().round(), 0.0) } else { r.place(1.0) } * scale;
        let path = VectorPath::from_points((0..count).map(|_| place(&mut random)).collect(), true).unwrap();
        let style = Style {
            stroke: stroked(scale * random.signed(), LineCap::Round, LineJoin::Miter, &[0.1 * scale]).stroke,
            ..filled(if round % 2 == 0 { FillRule::EvenOdd } else { FillRule::NonZero })
        };
        let picture = picture(&[path], &style);
        let mut points = picture.points();
        let mesh = made(&picture, &points);
        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()), "round {round}");
        assert!(mesh.indices.iter().all(|i| (*i as usize) < mesh.positions.len()));
        assert!(!points.set(0, [Vec3::NAN]) && !points.set(9, [Vec3::ZERO]));
    }
    let empty = Picture::default();
    assert_eq!(made(&empty, &empty.points()).bounds(), None);
}

#[test]
fn strokes_that_are_far_too_wide_stay_small_in_memory() {
    for width in [1e7, 1e30, f64::MAX] {
        let style = stroked(width, LineCap::Round, LineJoin::Round, &[]);
        let picture = picture(&[circle(DVec2::ZERO, 50.0, false)], &style);
        let mesh = made(&picture, &picture.points());
        assert!(mesh.positions.len() < 100_000, "{width}: {} vertices", mesh.positions.len());
        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()), "{width}");
    }
}
