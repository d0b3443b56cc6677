//! One mesh has one fingerprint, whatever file or engine it comes from, and its splines come back on all of them.
#![cfg(feature = "formats")]

use std::fmt::Write as _;

use bevy_surface_splines::format::document::{Document, SurfaceReference};
use bevy_surface_splines::format::{MeshFormat, parse_mesh};
use bevy_surface_splines::geodesic::PathFinder;
use bevy_surface_splines::surface::TriangleMesh;

use super::{build, mesh, splines};

/// Corner positions of all faces, as `f32`.
fn corners(mesh: &TriangleMesh) -> impl Iterator<Item = [f32; 3]> {
    mesh.faces.iter().flatten().map(|v| mesh.positions[*v as usize].as_vec3().to_array())
}

fn obj(mesh: &TriangleMesh, is_single: bool) -> Vec<u8> {
    let mut out = String::new();
    for p in &mesh.positions {
        let s = p.as_vec3();
        let _ = if is_single {
            writeln!(out, "v {} {} {}", s.x, s.y, s.z)
        } else {
            writeln!(out, "v {} {} {}", p.x, p.y, p.z)
        };
    }
    mesh.faces.iter().for_each(|[a, b, c]| writeln!(out, "f {} {} {}", a + 1, b + 1, c + 1).unwrap());
    out.into_bytes()
}

fn off(mesh: &TriangleMesh) -> Vec<u8> {
    let mut out = format!("OFF\n{} {} 0\n", mesh.positions.len(), mesh.faces.len());
    mesh.positions.iter().for_each(|p| writeln!(out, "{:e} {:e} {:e}", p.x, p.y, p.z).unwrap());
    mesh.faces.iter().for_each(|[a, b, c]| writeln!(out, "3 {a} {b} {c}").unwrap());
    out.into_bytes()
}

fn ply(mesh: &TriangleMesh, kind: &str) -> Vec<u8> {
    let mut out = format!(
        "ply\nformat binary_big_endian 1.0\nelement vertex {}\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.faces.len()
    )
    .into_bytes();
    for x in mesh.positions.iter().flat_map(|p| p.to_array()) {
        if kind == "float" { out.extend((x as f32).to_be_bytes()) } else { out.extend(x.to_be_bytes()) }
    }
    for face in &mesh.faces {
        out.push(3);
        face.iter().for_each(|v| out.extend(v.to_be_bytes()));
    }
    out
}

fn stl(mesh: &TriangleMesh) -> Vec<u8> {
    let mut out = vec![b' '; 80];
    out.extend((mesh.faces.len() as u32).to_le_bytes());
    let all: Vec<[f32; 3]> = corners(mesh).collect();
    for triangle in all.as_chunks::<3>().0 {
        out.extend([0; 12]);
        triangle.as_flattened().iter().for_each(|x| out.extend(x.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

fn stl_text(mesh: &TriangleMesh) -> Vec<u8> {
    let mut out = String::from("solid x\n");
    for (i, [x, y, z]) in corners(mesh).enumerate() {
        if i % 3 == 0 {
            out.push_str("facet normal 0 0 0\nouter loop\n");
        }
        writeln!(out, "vertex {x:e} {y:e} {z:e}").unwrap();
        if i % 3 == 2 {
            out.push_str("endloop\nendfacet\n");
        }
    }
    out.push_str("endsolid x\n");
    out.into_bytes()
}

/// With indices, or with a vertex for each corner.
fn glb(mesh: &TriangleMesh, is_indexed: bool) -> Vec<u8> {
    let positions: Vec<[f32; 3]> = if is_indexed {
        mesh.positions.iter().map(|p| p.as_vec3().to_array()).collect()
    } else {
        corners(mesh).collect()
    };
    let mut data: Vec<u8> = positions.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let split = data.len();
    let mut indices = String::new();
    let mut views = format!(r#"{{"buffer":0,"byteLength":{split}}}"#);
    let mut accessors = format!(r#"{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3"}}"#, positions.len());
    if is_indexed {
        data.extend(mesh.faces.iter().flatten().flat_map(|v| v.to_le_bytes()));
        indices.push_str(r#","indices":1"#);
        write!(views, r#",{{"buffer":0,"byteOffset":{split},"byteLength":{}}}"#, data.len() - split).unwrap();
        write!(
            accessors,
            r#",{{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}"#,
            3 * mesh.faces.len()
        )
        .unwrap();
    }
    let mut json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}{indices}}}]}}],"accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{{"byteLength":{}}}]}}"#,
        data.len()
    );
    while json.len() % 4 != 0 {
        json.push(' ');
    }
    let mut out = b"glTF".to_vec();
    out.extend(2_u32.to_le_bytes());
    out.extend(((28 + json.len() + data.len()) as u32).to_le_bytes());
    out.extend((json.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(json.as_bytes());
    out.extend((data.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(data);
    out
}

#[test]
fn one_mesh_has_one_fingerprint() {
    let original = mesh(20, 10);
    let surface = build(&original);
    let mut document = Document::new(SurfaceReference::of(&surface));
    for spline in splines(&surface) {
        document.add(&surface, "", &spline).unwrap();
    }
    for (name, bytes, format) in [
        ("OBJ", obj(&original, false), MeshFormat::Obj),
        ("OBJ of f32", obj(&original, true), MeshFormat::Obj),
        ("OFF", off(&original), MeshFormat::Off),
        ("PLY of double", ply(&original, "double"), MeshFormat::Ply),
        ("PLY of float", ply(&original, "float"), MeshFormat::Ply),
        ("binary STL", stl(&original), MeshFormat::Stl),
        ("text STL", stl_text(&original), MeshFormat::Stl),
        ("GLB", glb(&original, true), MeshFormat::Glb),
        ("GLB without indices", glb(&original, false), MeshFormat::Glb),
    ] {
        let read = parse_mesh(&bytes, format).unwrap();
        let there = build(&read);
        assert_eq!(there.fingerprint(), surface.fingerprint(), "{name}");
        assert_eq!(there.face_count(), surface.face_count(), "{name}");
        let restored = document.restore(&there, &mut PathFinder::new()).unwrap();
        assert!(restored.mapping.is_none(), "{name}");
        // Where positions were rounded, lengths were measured anew; places are the same bits everywhere.
        let exact = read.positions.iter().zip(&original.positions).all(|(a, b)| a == b) && name != "binary STL";
        for (a, b) in splines(&surface).iter().zip(restored.splines.iter().flatten()) {
            assert!(!exact || a == b, "{name}");
            for (a, b) in a.anchors().iter().zip(b.anchors()) {
                assert_eq!((a.point(), a.join()), (b.point(), b.join()), "{name}");
                for (a, b) in [(a.incoming(), b.incoming()), (a.outgoing(), b.outgoing())] {
                    assert_eq!((a.leg().crossings(), a.point()), (b.leg().crossings(), b.point()), "{name}");
                    assert!((a.leg().length() - b.leg().length()).abs() < 1e-6, "{name}");
                    assert!((a.wished_length() - b.wished_length()).abs() < 1e-6, "{name}");
                }
            }
        }
    }
}

#[cfg(feature = "bevy")]
#[test]
fn the_mesh_of_the_engine_has_the_same_fingerprint() {
    use bevy_surface_splines::plugin::{mesh_from, triangle_mesh_from};
    let original = mesh(20, 10);
    let bevy = mesh_from(&original);
    let mut split = bevy.clone();
    split.duplicate_vertices(); // as render meshes are, where normals break
    for mesh in [bevy, split] {
        let triangles = triangle_mesh_from(&mesh).unwrap();
        assert_eq!(triangles.fingerprint(), original.fingerprint());
        assert_eq!(build(&triangles).fingerprint(), build(&original).fingerprint());
    }
}

#[test]
fn corpus_meshes_have_one_fingerprint_in_all_formats() {
    let Ok(corpus) = std::env::var("SURFACE_CORPUS") else {
        println!("skipped: fingerprints of corpus meshes (SURFACE_CORPUS is not set)");
        return;
    };
    let mut count = 0;
    let mut entries: Vec<_> =
        std::fs::read_dir(format!("{corpus}/meshes")).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries.iter().filter(|path| path.metadata().is_ok_and(|m| m.is_file() && m.len() < 3_000_000)) {
        let Ok(original) = bevy_surface_splines::format::read_mesh(path) else { continue };
        for (bytes, format) in [
            (obj(&original, false), MeshFormat::Obj),
            (ply(&original, "float"), MeshFormat::Ply),
            (stl(&original), MeshFormat::Stl),
            (glb(&original, true), MeshFormat::Glb),
        ] {
            let read = parse_mesh(&bytes, format).unwrap();
            assert_eq!(read.fingerprint(), original.fingerprint(), "{} as {format}", path.display());
        }
        count += 1;
    }
    println!("{count} meshes");
    assert!(count > 10);
}
