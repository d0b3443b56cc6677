//! A made figure of 400 curves on 13 joints.

use std::fmt::Write;

use bevy_surface_splines::character::Character;

/// Bones of the figure: name, parent, and both ends.
const BONES: [(&str, &str, [f64; 2], [f64; 2]); 13] = [
    ("hips", "", [200.0, 220.0], [200.0, 180.0]),
    ("chest", "hips", [200.0, 180.0], [200.0, 110.0]),
    ("head", "chest", [200.0, 100.0], [200.0, 40.0]),
    ("arm-l", "chest", [180.0, 115.0], [130.0, 130.0]),
    ("fore-l", "arm-l", [130.0, 130.0], [80.0, 150.0]),
    ("hand-l", "fore-l", [80.0, 150.0], [60.0, 155.0]),
    ("arm-r", "chest", [220.0, 115.0], [270.0, 130.0]),
    ("fore-r", "arm-r", [270.0, 130.0], [320.0, 150.0]),
    ("hand-r", "fore-r", [320.0, 150.0], [340.0, 155.0]),
    ("leg-l", "hips", [190.0, 220.0], [180.0, 290.0]),
    ("shin-l", "leg-l", [180.0, 290.0], [175.0, 360.0]),
    ("leg-r", "hips", [210.0, 220.0], [220.0, 290.0]),
    ("shin-r", "leg-r", [220.0, 290.0], [225.0, 360.0]),
];

/// Shapes of ten curves each.
const SHAPES: usize = 40;

/// A figure of 400 curves: along each bone shapes with a fill and a stroke, which follow the bone and the one that carries it.
pub(crate) fn figure() -> Result<Character, String> {
    let (mut svg, mut parts) = (String::new(), String::new());
    for shape in 0..SHAPES {
        let (name, parent, from, to) = BONES[shape % BONES.len()];
        let size = 14.0 - 3.0 * (shape / BONES.len()) as f64;
        let (across, along) = (size, 0.6 * (to[0] - from[0]).hypot(to[1] - from[1]) + size);
        let turn = (to[1] - from[1]).atan2(to[0] - from[0]);
        let at = |k: f64, reach: f64| {
            let angle = std::f64::consts::TAU * k / 10.0;
            let (x, y) = (reach * along * angle.cos(), reach * across * angle.sin());
            let (s, c) = turn.sin_cos();
            format!("{:.4} {:.4}", 0.5 * (from[0] + to[0]) + c * x - s * y, 0.5 * (from[1] + to[1]) + s * x + c * y)
        };
        let mut path = format!("M {}", at(0.0, 1.0));
        for k in 0..10 {
            let k = f64::from(k);
            let _ = write!(path, " C {} {} {}", at(k + 0.35, 1.02), at(k + 0.65, 1.02), at(k + 1.0, 1.0));
        }
        let color = 0x10_20_30 + 0x03_05_04 * shape;
        let _ = writeln!(
            svg,
            r##"<path id="s{shape}" fill="#{color:06x}" stroke="#111" stroke-width="1.5" d="{path} z"/>"##
        );
        let follows = if parent.is_empty() { format!("{name:?}") } else { format!("{name:?}, {parent:?}") };
        let _ = writeln!(parts, r#"(name: "p{shape}", shapes: ["s{shape}"], follows: [{follows}]),"#);
    }
    let mut joints = String::new();
    let mut tracks = String::new();
    for (number, (name, parent, at, tip)) in BONES.iter().enumerate() {
        let parent = if parent.is_empty() { String::new() } else { format!("parent: {parent:?}, ") };
        let _ =
            writeln!(joints, "(name: {name:?}, {parent}at: ({}, {}), tip: ({}, {})),", at[0], at[1], tip[0], tip[1]);
        let swing = 8.0 + 3.0 * number as f64;
        let _ = writeln!(tracks, "(joint: {name:?}, keys: Rotation([(0, {}), (0.5, {})])),", -swing, swing);
    }
    let text = format!(
        r#"(version: 1, name: "figure", drawing: "figure.svg", joints: [{joints}], parts: [{parts}],
        clips: [(name: "walk", duration: 1, loops: true, tracks: [{tracks}])])"#
    );
    let svg = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 400">{svg}</svg>"#);
    Character::parse("figure.character.ron", text.as_bytes(), |_| Ok(svg.into_bytes())).map_err(|e| e.to_string())
}
