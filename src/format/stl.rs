//! Stereolithography files (STL), as text and binary.

use glam::DVec3;

use super::error::{Cause, Fault};
use super::text::{Text, decoded};
use crate::surface::TriangleMesh;

/// Bytes before the triangles of a binary file: a free header of 80 bytes and the count.
const HEADER: usize = 84;
/// Bytes of one binary triangle: normal, three corners, two bytes of attributes.
const RECORD: usize = 50;

/// Reads text and binary files, told apart by what fits: a binary file may begin with `solid` as well.
///
/// Every corner becomes a vertex of its own, in file order; normals and attributes are skipped. Bytes after the announced
/// triangles are tolerated.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, Fault> {
    if is_binary_of_exact_size(bytes) {
        return parse_binary(bytes);
    }
    let text = decoded(bytes);
    if is_text(&text) { parse_text(&text) } else { parse_binary(bytes) }
}

/// Whether the announced triangles fill the file exactly.
pub(super) fn is_binary_of_exact_size(bytes: &[u8]) -> bool {
    triangle_count(bytes).is_some_and(|count| HEADER as u64 + count * RECORD as u64 == bytes.len() as u64)
}

/// Whether the file begins with `solid` and has no zero bytes near its start, as binary files have.
pub(super) fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(512)];
    let first = Text::new(start).word_anywhere().unwrap_or_default();
    first.eq_ignore_ascii_case(b"solid") && !start.contains(&0)
}

fn triangle_count(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..)?.first_chunk::<4>()?;
    Some(u64::from(u32::from_le_bytes(*count)))
}

fn parse_binary(bytes: &[u8]) -> Result<TriangleMesh, Fault> {
    let Some(count) = triangle_count(bytes) else {
        let nothing = Cause::NothingFound("neither `solid` nor a header of 84 bytes");
        return Err(if bytes.is_empty() {
            Fault::byte(0, Cause::NothingFound("the file is empty"))
        } else {
            Fault::byte(bytes.len(), nothing)
        });
    };
    let body = &bytes[HEADER..];
    let room = body.len() as u64;
    if count * RECORD as u64 > room || (count == 0 && room > 0) {
        return Err(Fault::byte(80, Cause::CountTooLarge { what: "triangles", count, room }));
    }
    if count * 3 > u64::from(u32::MAX) {
        return Err(Fault::byte(80, Cause::TooManyVertices));
    }
    let count = count as usize;
    let mut mesh =
        TriangleMesh { positions: Vec::with_capacity(3 * count), faces: (0..count as u32).map(corners).collect() };
    let (records, _) = body.as_chunks::<RECORD>();
    for record in &records[..count] {
        let (numbers, _) = record.as_chunks::<4>();
        let number = |k: usize| f64::from(f32::from_le_bytes(numbers[k]));
        // The first three numbers are the normal.
        mesh.positions.extend([3, 6, 9].map(|k| DVec3::new(number(k), number(k + 1), number(k + 2))));
    }
    Ok(mesh)
}

/// Corners of the triangle with this number.
fn corners(face: u32) -> [u32; 3] {
    [3 * face, 3 * face + 1, 3 * face + 2]
}

/// What the text reader is inside of.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Inside {
    /// Nothing: before the first solid, or between two.
    File,
    Solid,
    Facet,
    Loop,
}

/// Reads any number of solids. Words are looked at, lines are not, except that the rest of a line is skipped after a solid's
/// name and after words that mean nothing.
fn parse_text(bytes: &[u8]) -> Result<TriangleMesh, Fault> {
    let mut text = Text::new(bytes);
    let mut mesh = TriangleMesh::default();
    let mut inside = Inside::File;
    let mut polygon = Vec::new();
    while let Some(word) = text.word_anywhere() {
        let (small, length) = in_small(word);
        inside = match (&small[..length], inside) {
            (b"solid", Inside::File) => {
                text.next_line();
                Inside::Solid
            }
            (b"endsolid", Inside::Solid) => {
                text.next_line();
                Inside::File
            }
            (b"facet", Inside::Solid) => Inside::Facet,
            (b"normal", Inside::Facet) => {
                for _ in 0..3 {
                    text.word();
                }
                inside
            }
            (b"outer", Inside::Facet) => Inside::Loop,
            (b"loop", Inside::Loop) if polygon.is_empty() => inside,
            (b"vertex", Inside::Loop) => {
                polygon.push(vertex(&mut text, &mut mesh)?);
                inside
            }
            (b"endloop", Inside::Loop) => {
                if polygon.len() < 3 {
                    return Err(Fault::line(text.line(), Cause::Missing("a corner of the facet")));
                }
                mesh.push_polygon(&polygon);
                polygon.clear();
                Inside::Facet
            }
            (b"endfacet", Inside::Facet) => Inside::Solid,
            (b"solid" | b"endsolid" | b"facet" | b"outer" | b"vertex" | b"endloop" | b"endfacet", _)
            | (_, Inside::Loop) => return Err(text.unexpected(inside.expects(), word)),
            _ => {
                text.next_line();
                inside
            }
        };
    }
    if inside == Inside::File { Ok(mesh) } else { Err(Fault::line(text.line(), Cause::EndsEarly(inside.name()))) }
}

/// The first letters of a word in small, as many as the longest keyword has and one more.
fn in_small(word: &[u8]) -> ([u8; 9], usize) {
    let mut small = [0; 9];
    let length = word.len().min(small.len());
    small[..length].copy_from_slice(&word[..length]);
    small.make_ascii_lowercase();
    (small, length)
}

fn vertex(text: &mut Text<'_>, mesh: &mut TriangleMesh) -> Result<u32, Fault> {
    let x = text.number("the x coordinate of a vertex")?;
    let y = text.number("the y coordinate of a vertex")?;
    let z = text.number("the z coordinate of a vertex")?;
    let index = u32::try_from(mesh.positions.len());
    let index = index.map_err(|_| Fault::line(text.line(), Cause::TooManyVertices))?;
    mesh.positions.push(DVec3::new(x, y, z));
    Ok(index)
}

impl Inside {
    fn expects(self) -> &'static str {
        match self {
            Self::File => "`solid`",
            Self::Solid => "`facet` or `endsolid`",
            Self::Facet => "`outer loop` or `endfacet`",
            Self::Loop => "`vertex` or `endloop`",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::File => "nothing",
            Self::Solid => "a solid (`endsolid` is missing)",
            Self::Facet => "a facet",
            Self::Loop => "a facet's loop",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::error::Place;
    use super::*;

    const FACET: &str =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e0 0\nendloop\nendfacet\n";

    fn binary(header: &[u8], count: u32, records: usize) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(count.to_le_bytes());
        for k in 0..records {
            (0..12).for_each(|n| bytes.extend((k as f32 + n as f32).to_le_bytes()));
            bytes.extend([0, 0]);
        }
        bytes
    }

    #[test]
    fn several_solids_of_text() {
        let mesh = parse(format!("solid a vertex\n{FACET}endsolid a\nSOLID\n{FACET}color 1 2 3\nendsolid").as_bytes());
        let mesh = mesh.unwrap();
        assert_eq!(mesh.faces, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(mesh.positions[5], DVec3::Y);
    }

    #[test]
    fn binary_is_told_by_its_size() {
        for header in [&b"solid facet"[..], b"", b"\0"] {
            let mesh = parse(&binary(header, 2, 2)).unwrap();
            assert_eq!(mesh.faces, [[0, 1, 2], [3, 4, 5]]);
            assert_eq!(mesh.positions[3], DVec3::new(4.0, 5.0, 6.0));
        }
        assert_eq!(parse(&binary(b"", 1, 2)).unwrap().faces.len(), 1);
    }

    #[test]
    fn errors_name_line_or_byte() {
        let fails = |bytes: &[u8]| parse(bytes).unwrap_err();
        assert_eq!(fails(&binary(b"", u32::MAX, 2)).place, Place::Byte(80));
        assert!(matches!(fails(&binary(b"", 3, 2)).cause, Cause::CountTooLarge { count: 3, room: 100, .. }));
        assert!(matches!(fails(b"").cause, Cause::NothingFound(_)));
        assert_eq!(fails(b"\0\0").place, Place::Byte(2));
        let text = |body: &str| fails(format!("solid\n{body}").as_bytes());
        assert_eq!(text(&FACET.replace("1e0", "one")).place, Place::Line(6));
        assert_eq!(text(&FACET.replace("vertex 1 0 0\n", "")).cause, Cause::Missing("a corner of the facet"));
        assert_eq!(text(&FACET.replace("vertex 1 0 0", "vertex 1 0")).place, Place::Line(5));
        assert_eq!(text(&FACET[..43]).cause, Cause::EndsEarly("a facet's loop"));
        assert!(matches!(text(FACET).cause, Cause::EndsEarly(_)));
    }
}
