//! Traces as lines: what was written is read back by other means, and compared with the trace.

use bevy_surface_splines::curve::{Method, Scheme, Spline, SplineEdit, Trace, TraceWorkspace, Tracer};
use bevy_surface_splines::format::export::{ExportError, TraceExport};
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::surface::{Surface, SurfaceOptions, SurfacePoint, shapes};
use glam::{DVec2, DVec3};

const NAME: &str = "a \"b\", \\c\n";

fn torus() -> Surface {
    Surface::build(&shapes::torus(1.0, 0.45, 48, 24), &SurfaceOptions::default()).unwrap()
}

fn at(surface: &Surface, u: f64, v: f64) -> SurfacePoint {
    let out = 1.0 + 0.45 * v.cos();
    surface.closest_point(DVec3::new(out * u.sin(), out * u.cos(), 0.45 * v.sin())).unwrap().point
}

/// A closed spline, and a curve that is torn.
fn traces(surface: &Surface) -> [Trace; 2] {
    let points = [(0.1, 0.3), (1.2, 1.0), (0.7, 2.0)].map(|(u, v)| at(surface, u, v));
    let mut finder = PathFinder::new();
    let mut spline = Spline::smooth_through(surface, &mut finder, &points, true).unwrap();
    spline.apply(surface, &mut finder, &SplineEdit::Reverse).unwrap();
    let closed = spline.trace(surface, &mut TraceWorkspace::default(), None).unwrap();
    // So large that the legs of the construction change sides.
    let near = |(u, v): (f64, f64)| {
        let out = 1.0 + 0.45 * v.cos();
        surface.closest_point(DVec3::new(out * u.sin(), 0.45 * v.sin(), out * u.cos())).unwrap().point
    };
    let polygon = [(-2.25, 0.775), (-1.0125, 1.45), (1.0125, 0.55), (2.25, 1.225)].map(near);
    let torn = Tracer::new(surface).trace(&polygon, &Scheme::of(Method::Direct)).unwrap();
    assert!(torn.pieces().len() > 1);
    [closed, torn]
}

fn exported(surface: &Surface) -> ([Trace; 2], TraceExport) {
    let traces = traces(surface);
    let mut export = TraceExport::default();
    for trace in &traces {
        export.add(surface, NAME, trace).unwrap();
    }
    (traces, export)
}

/// A line that was read back: positions, normals, distances.
type Line = Vec<(DVec3, DVec3, f64)>;

/// Compares lines with the traces' pieces; distances are summed up here.
fn assert_lines(surface: &Surface, traces: &[Trace], lines: &[Line], tolerance: f64) {
    let mut lines = lines.iter();
    for trace in traces {
        let positions = trace.positions();
        let mut distances = vec![0.0];
        positions.windows(2).for_each(|p| distances.push(distances[distances.len() - 1] + p[0].distance(p[1])));
        for piece in trace.pieces() {
            let line = lines.next().expect("a line for each piece");
            assert_eq!(line.len(), piece.len());
            for (i, (position, normal, distance)) in piece.zip(line) {
                assert!(position.distance(positions[i]) <= tolerance, "{position} {}", positions[i]);
                assert!((distance - distances[i]).abs() <= 1e-9 + tolerance * (1.0 + distances[i]));
                // The normal of the smooth torus, which that of its facets is near.
                let flat = DVec2::new(position.x, position.y).normalize();
                let smooth = (*position - flat.extend(0.0)).normalize();
                assert!((normal.length() - 1.0).abs() < 1e-6 && normal.dot(smooth).abs() > 0.95, "{normal} {smooth}");
                let face = surface.closest_point(positions[i]).unwrap().point;
                assert!(surface.normal(&face).dot(*normal) > 0.9);
            }
        }
    }
    assert!(lines.next().is_none());
}

#[test]
fn obj_lines_are_read_back() {
    let surface = torus();
    let (traces, export) = exported(&surface);
    let text = export.to_obj();
    let (mut v, mut vt, mut vn, mut lines, mut names) = (Vec::new(), Vec::new(), Vec::new(), Vec::new(), 0);
    for line in text.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        let numbers = || words[1..].iter().map(|w| w.parse::<f64>().unwrap()).collect::<Vec<_>>();
        match words[0] {
            "v" => v.push(DVec3::from_slice(&numbers())),
            "vn" => vn.push(DVec3::from_slice(&numbers())),
            "vt" => vt.push(numbers()[0]),
            "l" => {
                let pairs = words[1..].iter().map(|w| w.split_once('/').unwrap());
                lines.push(
                    pairs
                        .map(|(a, b)| (a.parse::<usize>().unwrap() - 1, b.parse::<usize>().unwrap() - 1))
                        .collect::<Vec<_>>(),
                );
            }
            "o" => names += 1,
            other => panic!("{other}"),
        }
    }
    assert_eq!(names, 2);
    let lines: Vec<Line> = lines.iter().map(|l| l.iter().map(|(a, b)| (v[*a], vn[*a], vt[*b])).collect()).collect();
    assert_lines(&surface, &traces, &lines, 0.0);
}

#[test]
fn csv_rows_are_read_back() {
    let surface = torus();
    let (traces, export) = exported(&surface);
    let text = export.to_csv();
    let text = text.replace(&format!("\"{}\"", NAME.replace('"', "\"\"")), "NAME");
    let mut rows = text.lines();
    assert_eq!(rows.next(), Some("curve,line,x,y,z,normal_x,normal_y,normal_z,distance"));
    let mut lines: Vec<Line> = Vec::new();
    let mut number = usize::MAX;
    for row in rows {
        let fields: Vec<&str> = row.split(',').collect();
        assert_eq!((fields.len(), fields[0]), (9, "NAME"));
        let x: Vec<f64> = fields[1..].iter().map(|f| f.parse().unwrap()).collect();
        if x[0] as usize != number || x[7] == 0.0 {
            number = x[0] as usize;
            lines.push(Vec::new());
        }
        lines.last_mut().unwrap().push((DVec3::from_slice(&x[1..4]), DVec3::from_slice(&x[4..7]), x[7]));
    }
    assert_lines(&surface, &traces, &lines, 0.0);
}

#[cfg(feature = "formats")]
#[test]
fn glb_lines_are_read_back() {
    let surface = torus();
    let (traces, export) = exported(&surface);
    let bytes = export.to_glb().unwrap();
    let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&bytes).expect("valid glTF");
    let blob = blob.expect("a buffer");
    let (mut lines, mut nodes) = (Vec::new(), 0);
    for node in document.default_scene().unwrap().nodes() {
        nodes += 1;
        assert_eq!(node.name(), Some(NAME));
        for primitive in node.mesh().unwrap().primitives() {
            assert_eq!(primitive.mode(), gltf::mesh::Mode::LineStrip);
            let reader = primitive.reader(|_| Some(&blob[..]));
            let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            let normals: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
            let of_distance = gltf::Semantic::Extras("DISTANCE".to_owned());
            let accessor = primitive.get(&of_distance).expect("distances");
            let view = accessor.view().unwrap();
            let distances = &blob[view.offset()..view.offset() + view.length()];
            let distances: Vec<f32> = distances.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            assert_eq!(
                (accessor.count(), positions.len(), normals.len()),
                (distances.len(), distances.len(), distances.len())
            );
            let bounds = primitive.bounding_box();
            for (k, (least, most)) in bounds.min.into_iter().zip(bounds.max).enumerate() {
                let all = positions.iter().map(|p| p[k]);
                assert_eq!((all.clone().reduce(f32::min), all.reduce(f32::max)), (Some(least), Some(most)));
            }
            let wide = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
            let all = positions.iter().zip(&normals).zip(&distances);
            lines.push(all.map(|((p, n), d)| (wide(*p), wide(*n), f64::from(*d))).collect::<Line>());
        }
    }
    assert_eq!(nodes, 2);
    assert_lines(&surface, &traces, &lines, 2.0 * f64::from(f32::EPSILON));
    // Nothing is valid too.
    let nothing = gltf::Gltf::from_slice(&TraceExport::default().to_glb().unwrap()).expect("valid glTF");
    assert_eq!(nothing.nodes().count(), 0);
}

#[test]
fn files_are_named_by_their_format_and_replaced_as_a_whole() {
    let surface = torus();
    let (traces, export) = exported(&surface);
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("exports");
    std::fs::create_dir_all(&folder).unwrap();
    for (name, content) in [
        ("a.obj", export.to_obj().into_bytes()),
        ("a.CSV", export.to_csv().into_bytes()),
        ("a.glb", export.to_glb().unwrap()),
    ] {
        export.save(folder.join(name)).unwrap();
        assert_eq!(std::fs::read(folder.join(name)).unwrap(), content);
    }
    traces[0].write_obj(&surface, folder.join("b")).unwrap();
    traces[0].save_lines(&surface, folder.join("b.obj")).unwrap();
    assert_eq!(std::fs::read(folder.join("b")).unwrap(), std::fs::read(folder.join("b.obj")).unwrap());
    let error = export.save(folder.join("a.step")).unwrap_err();
    assert!(matches!(error, ExportError::UnknownFormat { .. }), "{error}");
    assert!(matches!(export.save(folder.join("no/a.obj")).unwrap_err(), ExportError::Save(_)));
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 5);
    let other = Surface::build(&shapes::icosphere(0), &SurfaceOptions::default()).unwrap();
    let error = TraceExport::default().add(&other, "x", &traces[0]).unwrap_err();
    assert!(matches!(error, ExportError::OtherSurface { .. }), "{error}");
    std::fs::remove_dir_all(folder).unwrap();
}
