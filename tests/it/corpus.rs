//! Surfaces built from the corpus: reports as its table says, repairs checked independently. Needs `SURFACE_CORPUS`.

use std::collections::HashMap;
use std::path::Path;

use bevy_surface_splines::format::read_mesh;
use bevy_surface_splines::surface::{FaceId, Surface, SurfaceOptions, VertexId};

/// Splits a line of a table at commas outside quotes.
fn columns(line: &str) -> Vec<String> {
    let mut out = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => out.push(String::new()),
            _ => out.last_mut().unwrap().push(c),
        }
    }
    out
}

/// After repair every edge has at most two faces, and the faces about every vertex hang together over edges that end there.
fn assert_repaired(surface: &Surface) -> Result<(), String> {
    let faces: Vec<[VertexId; 3]> =
        (0..surface.face_count() as u32).filter_map(|f| surface.vertices(FaceId(f)).ok()).collect();
    let mut edges: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
    let mut stars: HashMap<u32, Vec<usize>> = HashMap::new();
    for (face, t) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (t[k].0, t[(k + 1) % 3].0);
            edges.entry([a.min(b), a.max(b)]).or_default().push(face);
            stars.entry(a).or_default().push(face);
        }
    }
    if let Some((edge, faces)) = edges.iter().find(|(_, faces)| faces.len() > 2) {
        return Err(format!("edge {edge:?} has {} faces", faces.len()));
    }
    for (&vertex, star) in &stars {
        let mut met = vec![star[0]];
        let mut i = 0;
        while i < met.len() {
            for other in faces[met[i]].iter().filter(|v| v.0 != vertex) {
                let edge = [vertex.min(other.0), vertex.max(other.0)];
                for &face in &edges[&edge] {
                    if !met.contains(&face) {
                        met.push(face);
                    }
                }
            }
            i += 1;
        }
        if met.len() != star.len() {
            return Err(format!("vertex {vertex} has {} faces, of which {} hang together", star.len(), met.len()));
        }
    }
    Ok(())
}

#[test]
fn reports_are_as_listed_and_repairs_hold() {
    let Ok(corpus) = std::env::var("SURFACE_CORPUS") else {
        println!("skipped: reports of corpus meshes (SURFACE_CORPUS is not set)");
        return;
    };
    let corpus = Path::new(&corpus);
    let table = std::fs::read_to_string(corpus.join("meshes.csv")).unwrap();
    let mut lines = table.lines();
    let head = columns(lines.next().unwrap());
    let (mut differences, mut meshes, mut compared) = (Vec::new(), 0, 0);
    for line in lines {
        let row = columns(line);
        let value = |name: &str| row[head.iter().position(|h| h == name).unwrap()].as_str();
        let file = value("file");
        let surface = match Surface::build(&read_mesh(corpus.join(file)).unwrap(), &SurfaceOptions::default()) {
            Ok(surface) => surface,
            Err(error) => {
                differences.push(format!("{file}: {error}"));
                continue;
            }
        };
        meshes += 1;
        let report = surface.report();
        let truth = |b: bool| if b { "yes" } else { "no" }.to_string();
        for (name, ours) in [
            ("components", report.components.to_string()),
            ("boundary_edges", report.boundary_edges.to_string()),
            ("boundary_loops", report.boundary_loops.to_string()),
            ("nonmanifold_edges", report.nonmanifold_edges.to_string()),
            ("nonmanifold_vertices", report.nonmanifold_vertices.to_string()),
            ("orientable", truth(report.orientable)),
            ("consistently_oriented", truth(report.consistently_oriented)),
            ("euler", report.euler_characteristic.to_string()),
            ("degenerate_triangles", report.degenerate_faces.to_string()),
            ("duplicate_triangles", report.duplicate_faces.to_string()),
            ("isolated_vertices", report.isolated_vertices.to_string()),
        ] {
            if !value(name).is_empty() {
                compared += 1;
                if value(name) != ours {
                    differences.push(format!("{file}: {name} is {}, ours {ours}", value(name)));
                }
            }
        }
        if let Err(what) = assert_repaired(&surface) {
            differences.push(format!("{file}: {what}"));
        }
    }
    println!("{meshes} meshes, {compared} values compared");
    assert!(differences.is_empty(), "{}", differences.join("\n"));
    assert_eq!(meshes, 83);
}
