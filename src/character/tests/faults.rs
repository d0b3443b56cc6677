//! Every fault has an error of its own, with file, line and element.

use super::*;

fn fault_of(text: &str) -> (Place, String, CharacterFault) {
    match parse(text).unwrap_err() {
        CharacterError::Fault { place: Some(place), element, fault } => (place, element, fault),
        other => panic!("{other}"),
    }
}

#[test]
fn what_does_not_fit_is_named_with_its_line() {
    use CharacterFault as F;
    let long = "x".repeat(1001);
    let cases: Vec<(&str, &str, &str, F)> = vec![
        ("parent: \"upper\"", "parent: \"uper\"", "joint `fore`", F::NoSuchJoint { name: "uper".into() }),
        (
            "(name: \"hips\", at",
            "(name: \"hips\", parent: \"fore\", at",
            "joint `hips`",
            F::Cycle { names: ["hips", "fore", "upper", "hips"].map(String::from).into() },
        ),
        (
            "(name: \"hips\", at",
            "(name: \"hips\", parent: \"hips\", at",
            "joint `hips`",
            F::Cycle { names: ["hips", "hips"].map(String::from).into() },
        ),
        ("(name: \"neck\"", "(name: \"hips\"", "joint `hips`", F::SameName { what: "joint" }),
        ("name: \"head\", shapes", "name: \"\", shapes", "part ``", F::BadName { bytes: 0, limit: 1000 }),
        ("name: \"arm\"", "name: \"body\"", "part `body`", F::SameName { what: "part" }),
        ("name: \"jump\"", "name: \"wave\"", "clip `wave`", F::SameName { what: "clip" }),
        ("[\"fore\", \"upper\"]", "[\"fore\", \"lower\"]", "part `arm`", F::NoSuchJoint { name: "lower".into() }),
        ("[\"fore\", \"upper\"]", "[\"fore\", \"fore\"]", "part `arm`", F::SameJoint { name: "fore".into() }),
        ("[\"fore\", \"upper\"]", "[]", "part `arm`", F::FollowsNothing),
        ("shapes: [\"head\"]", "shapes: []", "part `head`", F::NoShapes),
        (
            "shapes: [\"head\"]",
            "shapes: [\"haed\"]",
            "part `head`",
            F::NoSuchShape { id: "haed".into(), drawing: "doll.svg".into() },
        ),
        (
            "shapes: [\"head\"]",
            "shapes: [\"arm\"]",
            "part `head`",
            F::SameShape { id: "arm".into(), other: "arm".into() },
        ),
        (
            "shapes: [\"figure\"]",
            "shapes: [\"guide\"]",
            "the character",
            F::NotInAPart { shape: "shape `trunk`".into() },
        ),
        (
            "shape: \"sleeve\", anchor: 2",
            "shape: \"hand\", anchor: 7",
            "part `arm`",
            F::NoSuchJoin { shape: "hand".into(), path: 0, anchor: 7 },
        ),
        (
            "shape: \"sleeve\", anchor: 2",
            "shape: \"sleeve\", path: 3, anchor: 2",
            "part `arm`",
            F::NoSuchJoin { shape: "sleeve".into(), path: 3, anchor: 2 },
        ),
        (
            "shape: \"sleeve\", anchor: 2",
            "shape: \"head\", anchor: 1",
            "part `arm`",
            F::NoSuchJoin { shape: "head".into(), path: 0, anchor: 1 },
        ),
        ("joint: \"neck\"", "joint: \"nack\"", "clip `wave`, track 1", F::NoSuchJoint { name: "nack".into() }),
        (
            "(joint: \"neck\"",
            "(joint: \"fore\"",
            "clip `wave`, rotation of joint `fore`",
            F::SameTrack { channel: "rotation", name: "fore".into() },
        ),
        ("[(0, -5), (1, 5)]", "[]", "clip `wave`, rotation of joint `neck`", F::NoKeys),
        ("(1, 5)]", "(0, 5)]", "clip `wave`, rotation of joint `neck`", F::KeyOrder { key: 1 }),
        ("(1, 5)]", "(2, 5)]", "clip `wave`, rotation of joint `neck`", F::KeyAtTheEnd { key: 1 }),
        (
            "(1, 5)]",
            "(2.5, 5)]",
            "clip `wave`, rotation of joint `neck`",
            F::OutOfRange { what: "its time", found: 2.5, least: 0.0, most: 2.0 },
        ),
        (
            "duration: 0.8",
            "duration: 0",
            "clip `jump`",
            F::OutOfRange { what: "its duration", found: 0.0, least: 1e-3, most: 86_400.0 },
        ),
        (
            "Shepard(power: 3)",
            "Bounded(triangles: 3)",
            "weights of all parts",
            F::OutOfRange { what: "the number of triangles", found: 3.0, least: 16.0, most: 20_000.0 },
        ),
        (
            "Shepard(power: 3)",
            "Cage(corners: [(\"hips\", (0, 0))])",
            "part `arm`",
            F::CornerElsewhere { name: "hips".into() },
        ),
        ("name: \"jump\"", "name: \"LONG\"", "clip `LONG`", F::BadName { bytes: 1001, limit: 1000 }),
    ];
    for (what, instead, element, fault) in cases {
        let (instead, element) = (instead.replace("LONG", &long), element.replace("LONG", &long));
        assert!(TEXT.contains(what), "{what}");
        let text = TEXT.replacen(what, &instead, 1);
        let error = parse(&text).unwrap_err().to_string();
        println!("{:.300}", error);
        let (place, of, found) = fault_of(&text);
        assert_eq!((of, &found), (element, &fault), "{what} → {instead:.100}");
        assert!(error.starts_with(&format!("doll.character.ron, line {}, ", place.line)), "{error}");
        let line = match fault {
            F::NotInAPart { .. } => line_of(TEXT, "parts:"),
            F::CornerElsewhere { .. } => line_of(TEXT, "name: \"arm\""),
            _ => line_of(TEXT, what),
        };
        assert_eq!(place.line, line, "{error}");
    }
}

#[test]
fn empty_things_are_refused() {
    let none = TEXT.replace(&TEXT[TEXT.find("joints: [").unwrap()..TEXT.find("  parts").unwrap()], "joints: [],\n");
    let none = none[..none.find("  parts").unwrap()].to_owned() + "  parts: [],\n)";
    assert_eq!(fault_of(&none).2, CharacterFault::NoJoints);
    for drawing in
        ["<svg xmlns='http://www.w3.org/2000/svg'/>", "<svg xmlns='http://www.w3.org/2000/svg'><path d=''/></svg>"]
    {
        let error = Character::parse("a.character.ron", TEXT.as_bytes(), |_| Ok(drawing.into())).unwrap_err();
        let expected = "a.character.ron, line 4, column 12, the character: the drawing `doll.svg` is empty: draw something, or name another";
        assert_eq!(error.to_string(), expected);
    }
    let far = DRAWING.replace("M 120 95", "M 1e10 95");
    let error = Character::parse("a.character.ron", TEXT.as_bytes(), |_| Ok(far.into())).unwrap_err();
    assert!(matches!(error, CharacterError::Fault { fault: CharacterFault::FarDrawing { .. }, .. }), "{error}");
    let error = Character::parse("a.character.ron", TEXT.as_bytes(), |_| Ok("<svg".into())).unwrap_err().to_string();
    assert!(error.starts_with("a.character.ron, line 4, column 12, drawing `doll.svg`: SVG, line 1: "), "{error}");
}

#[test]
fn too_much_is_refused() {
    let joints: String = (0..=Character::MOST_JOINTS).map(|i| format!("(name: \"j{i}\", at: (0, {i})),\n")).collect();
    let text = TEXT.replacen("joints: [", &format!("joints: [{joints}"), 1);
    let fault = fault_of(&text).2;
    let limit = Character::MOST_JOINTS;
    assert_eq!(fault, CharacterFault::TooMany { what: "joints", found: limit + 5, limit });
    let keys: String = (1..=Character::MOST_KEYS).map(|i| format!(",({},0)", i as f64 * 1e-5)).collect();
    let text = TEXT.replacen("(0, -5), (1, 5)", &format!("(0, -5){keys}"), 1);
    let (place, _, fault) = fault_of(&text);
    assert!(matches!(fault, CharacterFault::TooMany { what: "keys", .. }), "{fault}");
    assert_eq!(place.line, line_of(&text, "clips:"));
    let text = TEXT.replacen("Shepard(power: 3)", "Bounded(triangles: 20000)", 1);
    let fault = fault_of(&text).2;
    assert!(
        matches!(fault, CharacterFault::TooCostly { what: "triangles times joints", found: 170_000.., .. }),
        "{fault}"
    );
    let long = format!("{TEXT}//{}", " ".repeat(4 << 20));
    assert!(matches!(parse(&long), Err(CharacterError::TooLarge { limit: 4_194_304, .. })));
    // Many segments that follow many joints.
    let joints: String = (0..500).map(|i| format!("(name: \"j{i}\", at: (0, {i})),\n")).collect();
    let all: String = (0..500).map(|i| format!("\"j{i}\",")).collect();
    let text = TEXT.replacen("joints: [", &format!("joints: [{joints}"), 1);
    let text = text.replacen("follows: [\"fore\"", &format!("follows: [{all}\"fore\""), 1);
    let line = "l 1 0 0 1".repeat(400);
    let drawing = DRAWING.replace("M 195 97", &format!("M 195 97 {line}"));
    let error = Character::parse("a", text.as_bytes(), |_| Ok(drawing.into())).unwrap_err();
    assert!(
        matches!(
            &error,
            CharacterError::Fault { fault: CharacterFault::TooCostly { what: "segments times joints", .. }, .. }
        ),
        "{error}"
    );
}

#[test]
fn texts_that_are_no_characters_are_refused() {
    let newer = parse("(version: 7, <<<").unwrap_err();
    assert!(matches!(newer, CharacterError::NewerVersion { found: 7, .. }), "{newer}");
    let other = parse("\n\n v 0 0 0").unwrap_err();
    assert_eq!(
        other.to_string(),
        "doll.character.ron, line 3, column 2: a character begins with `(version: 1,`: open a file of a character"
    );
    let bytes = Character::parse("a", b"(version: 1,\n \xff", |_| Ok(Vec::new())).unwrap_err();
    assert!(matches!(&bytes, CharacterError::Content { place: Place { line: 2, column: 2, .. }, .. }), "{bytes}");
    for (what, instead, field, problem) in [
        ("at: (160, 100)", "at: (160, NaN)", "joints[1].at", "NaN is not a number from"),
        ("at: (160, 100)", "at: (160, 1e10)", "joints[1].at", "not a number from"),
        ("angle: 90", "angle: inf", "joints[0].angle", "not a number from"),
        ("duration: 2", "duration: -2", "clips[0].duration", "not a number from 0.0 to 86400.0"),
        ("(0.5, 40)", "(-0.5, 40)", "clips[0].tracks[0].keys", "not a number from"),
        ("(0.8, (1.1, 0.9))", "(0.8, (1.1, 1e4))", "clips[1].tracks[1].keys", "not a number from"),
        ("power: 3", "power: 9", "weights", "9.0 is not a number from 1.0 to 8.0"),
        ("z: 1.5", "z: one", "parts[1].z", "float"),
        ("kind: Corner", "kind: Cornered", "parts[1].joins[0].kind", "Cornered"),
        ("easing: Step", "easing: Slow", "clips[1].tracks[0].easing", "Slow"),
        ("loops: true", "loop: true", "clips[0]", "loop"),
        ("keys: Scale(", "keys: Size(", "clips[1].tracks[1].keys", "Size"),
    ] {
        assert!(TEXT.contains(what), "{what}");
        let error = parse(&TEXT.replacen(what, instead, 1)).unwrap_err();
        println!("{error}");
        let CharacterError::Content { place, field: f, problem: p } = &error else { panic!("{error}") };
        let line = line_of(TEXT, what);
        assert!((line..line + 2).contains(&place.line) && f.starts_with(field) && p.contains(problem), "{error}");
    }
}

#[test]
fn characters_that_were_changed_are_checked_without_a_place() {
    let mut changed = doll();
    changed.parts[1].follows.push(99);
    let error = changed.bind(&BindProgress::default()).unwrap_err();
    assert_eq!(error.to_string(), "part `arm`: there is no joint `#99`: correct the name, or add the joint");
    let mut changed = doll();
    changed.clips[0].tracks[0].keys = Keys::Rotation(vec![(0.0, f64::NAN)]);
    assert!(matches!(changed.check(), Err(CharacterError::Fault { place: None, .. })));
    #[cfg(not(feature = "weights"))]
    {
        let text = TEXT.replacen("Shepard(power: 3)", "Bounded(triangles: 100)", 1);
        let error = parse(&text).unwrap().bind(&BindProgress::default()).unwrap_err();
        assert!(error.to_string().contains("feature `weights`"), "{error}");
    }
    let progress = BindProgress::default();
    progress.cancel();
    assert!(matches!(doll().bind(&progress), Err(CharacterError::Cancelled)));
}
