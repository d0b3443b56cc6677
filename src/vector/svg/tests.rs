//! Small documents whose drawings are known.

use glam::{DAffine2, DVec2};

use super::*;
use crate::vector::{Color, FillRule, GradientKind, Paint, Shape, Style};

fn import(inside: &str) -> SvgImport {
    let head =
        "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' viewBox='0 0 100 50'>";
    let import = import_svg(format!("{head}{inside}</svg>").as_bytes()).unwrap();
    assert!(import.report.adds_up(), "{:?}", import.report);
    import
}

fn starts(import: &SvgImport) -> Vec<[f64; 2]> {
    import.drawing.paths().map(|(_, path)| path.points()[0].to_array()).collect()
}

fn color(style: &Style) -> Option<[u8; 3]> {
    match style.fill? {
        Paint::Color(Color { red, green, blue, .. }) => Some([red, green, blue].map(|v| (v * 255.0).round() as u8)),
        Paint::Gradient { .. } => None,
    }
}

#[test]
fn transforms_copies_and_viewports_are_applied() {
    let import = import(
        "<defs><path id='p' d='M1 2h1'/><symbol id='s' viewBox='0 0 2 2'><path d='M1 1h1'/></symbol></defs>
         <g transform='translate(10 20)'><g transform='scale(2)'><path d='M1 2h1'/></g>
         <use xlink:href='#p' x='5' transform='scale(3)'/></g>
         <use href='#s' x='4' y='6' width='20' height='10'/>
         <svg x='50' width='50%' height='50' viewBox='0 0 10 20'><path d='M0 20h1'/></svg>",
    );
    // 10 + 2·1, 20 + 2·2; 10 + 3·(5 + 1), 20 + 3·2; the symbol's 2 × 2 in the middle of 20 × 10; 10 × 20 in 50 × 50.
    assert_eq!(starts(&import), [[12.0, 24.0], [28.0, 26.0], [14.0, 11.0], [62.5, 50.0]]);
    assert_eq!(import.report.in_copies.total(), 2);
    let left: Vec<String> = import.report.left_out.iter().map(ToString::to_string).collect();
    assert_eq!(left.len(), 2, "{left:?}");
    assert!(left[0].contains("inside `defs`") && left[1].contains("inside `defs`"), "{left:?}");
    assert_eq!(import.drawing.centre(), DVec2::new(50.0, 25.0));
}

#[test]
fn styles_cascade() {
    let import = import(
        "<style>.a { fill: #010203 } rect.a { fill: #040506 } #z { fill: #070809 !important }</style>
         <g fill='red' stroke='blue' stroke-width='2' color='#0a0b0c' opacity='0.5' fill-rule='evenodd'>
         <path d='M0 0h1'/><path class='a' d='M0 0h1'/><rect class='a' width='1' height='1'/>
         <path class='a' style='fill:#111213' d='M0 0h1'/><path id='z' style='fill:#111213' d='M0 0h1'/>
         <path fill='currentColor' opacity='50%' transform='scale(3 3)' d='M0 0h1'/><path fill='none' stroke='none' d='M0 0h1'/>
         <path fill='nonsense' d='M0 0h1'/></g>",
    );
    let found: Vec<Option<[u8; 3]>> = import.drawing.shapes.iter().map(|s| color(&s.style)).collect();
    let red = Some([255, 0, 0]);
    let listed =
        [red, Some([1, 2, 3]), Some([4, 5, 6]), Some([17, 18, 19]), Some([7, 8, 9]), Some([10, 11, 12]), None, red];
    assert_eq!(found, listed);
    let Shape { style, .. } = &import.drawing.shapes[5];
    assert_eq!((style.opacity, style.fill_rule), (0.25, FillRule::EvenOdd));
    assert!((style.stroke.as_ref().unwrap().width - 6.0).abs() < 1e-12);
    assert!(!import.drawing.shapes[6].style.is_visible());
}

#[test]
fn what_is_not_drawn_is_listed_with_its_reason() {
    let import = import(
        "<path display='none' d='M0 0h1v1'/><g visibility='hidden'><path d='M0 0h1'/><path visibility='visible' d='M0 0h1'/></g>
         <text>a<tspan>b</tspan></text><image href='a.png'/><clipPath id='c'><rect width='1' height='1'/></clipPath>
         <switch><foreignObject/><path systemLanguage='xx' d='M0 0h1'/><path d='M0 0h1'/><path d='M0 0h1'/></switch>
         <use href='#nothing'/><use id='u' href='#u'/><circle r='-1'/><rect width='x' height='1'/><path transform='scale(0)' d='M0 0h1'/>
         <path transform='turn(1)' d='M0 0h1'/><path d='M0 0h1e308h1e308'/><path clip-path='url(#c)' d='M0 0h1'/><thing/>
         <other:path xmlns:other='a.b' d='M0 0h1'/>",
    );
    let of = |what: &str| {
        import.report.left_out.iter().filter(|l| l.to_string().contains(what)).map(|l| l.segments.total()).sum::<u64>()
    };
    assert_eq!(of("display is none"), 2);
    assert_eq!(of("visibility"), 1);
    assert_eq!(of("inside `clipPath`"), 4);
    assert_eq!(of("another branch"), 2);
    assert_eq!(of("no extent"), 4);
    assert_eq!(of("`width` is no valid"), 4);
    assert_eq!(of("flattens"), 1);
    assert_eq!(of("`transform` is no valid"), 1);
    assert_eq!(of("not finite"), 2);
    for what in ["text has no outlines", "picture of pixels", "refers to nothing", "refers to itself", "not supported"]
    {
        assert!(import.report.left_out.iter().any(|l| l.to_string().contains(what)), "{what}");
    }
    assert_eq!(
        import.report.notes.iter().map(ToString::to_string).collect::<Vec<_>>(),
        ["line 5, path: `clip-path` is not applied"]
    );
    assert_eq!(import.report.drawn.total(), 3);
}

#[test]
fn gradients_are_paints() {
    let import = import(
        "<linearGradient id='a'><stop offset='0' stop-color='red'/><stop offset='50%' style='stop-color:blue;stop-opacity:.5'/></linearGradient>
         <radialGradient id='b' href='#a' gradientUnits='userSpaceOnUse' cx='3' cy='4' r='5'/><pattern id='c'/>
         <rect x='10' y='20' width='4' height='2' fill='url(#a)' fill-opacity='.5'/><circle r='3' transform='translate(1 2)' fill='url(#b)'/>
         <circle r='3' fill='url(#c) lime'/><path d='M0 0h5' fill='url(#a)'/>",
    );
    let [a, b] = &import.drawing.gradients[..] else { panic!("{:?}", import.drawing.gradients) };
    assert_eq!(a.kind, GradientKind::Linear { from: DVec2::ZERO, to: DVec2::X });
    assert_eq!(a.stops[1].color.alpha, 0.5);
    assert!(
        matches!(b.kind, GradientKind::Radial { centre, radius, .. } if centre == DVec2::new(3.0, 4.0) && radius == 5.0)
    );
    let paint = |i: usize| import.drawing.shapes[i].style.fill;
    let to_drawing = DAffine2::from_scale_angle_translation(DVec2::new(4.0, 2.0), 0.0, DVec2::new(10.0, 20.0));
    assert!(
        matches!(paint(0), Some(Paint::Gradient { index: 0, to_drawing: map, opacity: 0.5 }) if map.abs_diff_eq(to_drawing, 1e-12))
    );
    assert!(
        matches!(paint(1), Some(Paint::Gradient { index: 1, to_drawing: map, .. }) if map.translation == DVec2::new(1.0, 2.0))
    );
    assert_eq!(color(&import.drawing.shapes[2].style), Some([0, 255, 0]));
    // A line has no bounds to spread a gradient over.
    assert_eq!(paint(3), None);
    assert_eq!(import.report.notes.len(), 1);
    let again = import_svg(export_svg(&import.drawing).as_bytes()).unwrap();
    assert_eq!(again.drawing.gradients.len(), 2);
}

#[test]
fn exported_drawings_come_back() {
    let first = import(
        "<path id='a&amp;b' d='M1e-7 .1c1 2 3 4 5 6.7l1e20 3q1 2 3 3zM0 0a3 2 10 0 1 4 3' stroke='red' stroke-width='.3'
         stroke-dasharray='1 2 3' stroke-linecap='round' stroke-linejoin='bevel' fill='#12345678' fill-rule='evenodd' opacity='.3'/>",
    );
    let second = import_svg(export_svg(&first.drawing).as_bytes()).unwrap();
    assert_eq!(first.drawing, second.drawing);
}

#[test]
fn named_groups_are_known_by_what_is_drawn_in_them() {
    let import = import(
        "<g id='empty'><g id='defs-only'/></g><g id='a'><path id='p' d='M0 0h1'/><g><g id='b'><path d='M0 0h2'/></g></g></g>
         <use id='c' href='#b'/><path d='M0 0h3'/>",
    );
    let around = |shape: &Shape| {
        let ids = import.drawing.groups_of(shape).map(|(_, group)| group.id.as_str());
        ids.collect::<Vec<_>>().join(" ")
    };
    let found: Vec<String> = import.drawing.shapes.iter().map(around).collect();
    assert_eq!(found, ["a", "b a", "b c", ""]);
    let again = import_svg(export_svg(&import.drawing).as_bytes()).unwrap();
    assert_eq!(again.drawing, import.drawing);
}
