//! Reading and writing.

use glam::DVec2;

use super::*;
use crate::vector::{Paint, ViewBox};

#[test]
fn joints_come_behind_their_parents_and_y_goes_up() {
    let doll = doll();
    let names: Vec<&str> = doll.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!(names, ["hips", "upper", "fore", "neck"]);
    assert_eq!(doll.joints.iter().map(|joint| joint.parent).collect::<Vec<_>>(), [None, Some(0), Some(1), Some(0)]);
    assert_eq!(doll.joints[2].at, DVec2::new(160.0, -100.0));
    assert_eq!(doll.joints[0].angle, 90_f64.to_radians());
    assert_eq!(doll.drawing.view_box, Some(ViewBox { min: DVec2::new(0.0, -200.0), size: DVec2::splat(200.0) }));
    assert_eq!(doll.parts[1].follows, [2, 1]);
    let Keys::Translation(keys) = &doll.clips[0].tracks[2].keys else { panic!() };
    assert_eq!(keys[1], (1.0, DVec2::new(0.0, 4.1)));
    // A gradient goes where its shape goes: its line from left to right, at the same height.
    let Some(Paint::Gradient { to_drawing, .. }) = doll.drawing.shapes[1].style.fill else { panic!() };
    let [from, to] = [DVec2::ZERO, DVec2::X].map(|p| to_drawing.transform_point2(p));
    assert!(
        from.distance(DVec2::new(80.0, -85.0)) < 1e-9 && to.distance(DVec2::new(120.0, -85.0)) < 1e-9,
        "{from} {to}"
    );
}

#[test]
fn shapes_belong_to_the_part_that_names_them_most_closely() {
    let doll = doll();
    // The guide is not painted and belongs to none.
    assert_eq!(doll.assigned().unwrap(), [None, Some(0), Some(1), Some(1), Some(2)]);
    let bound = doll.bind(&BindProgress::default()).unwrap();
    let order: Vec<[usize; 3]> = bound.paths.iter().map(|path| [path.shape, path.path, path.chain]).collect();
    assert_eq!(order, [[4, 0, 4], [1, 0, 0], [1, 1, 1], [2, 0, 2], [3, 0, 3]]);
}

#[test]
fn what_is_written_reads_back() {
    let doll = doll();
    let text = doll.to_ron().unwrap();
    println!("{text}");
    let again = parse(&text).unwrap();
    assert_eq!(again, doll);
    assert_eq!(again.to_ron().unwrap(), text);
    // Digits are those that people wrote.
    assert!(text.contains("angle: -7.3") && text.contains("(1.5, 40.3)") && text.contains("(0.0, -4.1)"), "{text}");
}

#[test]
fn characters_made_in_a_program_are_written_as_they_are() {
    let mut made = doll();
    made.name = "with \"quotes\" and \\ and ü".to_owned();
    made.joints[3].angle = 1.0;
    made.joints[3].at.x = 0.1 + 0.2;
    made.parts[0].weights = Some(WeightSource::Bounded { triangles: 100, outline: vec![DVec2::new(1.0, -2.5); 3] });
    let corner = |joint, x| CageCorner { joint, at: DVec2::new(x, 0.0) };
    made.parts[1].weights =
        Some(WeightSource::Cage { triangles: 200, corners: vec![corner(1, 0.0), corner(2, 1.0), corner(1, 2.0)] });
    let again = parse(&made.to_ron().unwrap()).unwrap();
    // A radian is no number of degrees.
    assert!((again.joints[3].angle - 1.0).abs() < 1e-15);
    made.joints[3].angle = again.joints[3].angle;
    assert_eq!(again, made);
    made.joints[0].parent = Some(3);
    let error = made.to_ron().unwrap_err();
    assert_eq!(error.to_string(), "joint `hips`: the joint comes before its parent: put parents first");
}

#[test]
fn files_are_read_beside_their_drawing() {
    let folder = std::env::temp_dir().join(format!("character_read_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("doll.character.ron");
    std::fs::write(&path, TEXT).unwrap();
    let error = Character::read(&path).unwrap_err().to_string();
    assert!(error.contains("doll.character.ron, line 4, column 12, drawing `doll.svg`: "), "{error}");
    std::fs::write(folder.join("doll.svg"), DRAWING).unwrap();
    assert_eq!(Character::read(&path).unwrap(), doll());
    assert_eq!(Character::cache_path(&path), folder.join("doll.character.weights"));
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(matches!(Character::read(&path), Err(CharacterError::Io { .. })));
}
