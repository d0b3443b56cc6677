//! Wavefront OBJ.

use glam::DVec3;

use super::error::{Cause, Fault, shown};
use super::text::{Text, decoded, integer};
use crate::surface::TriangleMesh;

/// Reads `v` and `f` lines; all other lines are skipped.
///
/// Polygons become fans; faces with fewer than three corners are skipped. Indices count from one, negative ones backwards
/// from the latest vertex; a positive index may name a vertex that comes later. Only the part before the first `/` counts.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, Fault> {
    let decoded = decoded(bytes);
    let lines = Lines::count(&decoded);
    if lines.vertices + lines.faces == 0 {
        return Err(Fault::line(1, Cause::NothingFound("no `v` and no `f` line")));
    }
    let mut mesh =
        TriangleMesh { positions: Vec::with_capacity(lines.vertices), faces: Vec::with_capacity(lines.faces) };
    let mut corners = Vec::new();
    each_line(&decoded, |keyword, text| {
        match keyword {
            b"v" => mesh.positions.push(vertex(text, mesh.positions.len())?),
            b"f" | b"fo" => {
                face(text, mesh.positions.len(), lines.vertices, &mut corners)?;
                mesh.push_polygon(&corners);
            }
            _ => {}
        }
        Ok(())
    })?;
    Ok(mesh)
}

/// Calls `visit` with the first word of each line that has one.
fn each_line<'a>(
    bytes: &'a [u8],
    mut visit: impl FnMut(&'a [u8], &mut Text<'a>) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let mut text = Text::new(bytes).with_comments().with_continuations();
    while let Some(keyword) = text.word_anywhere() {
        visit(keyword, &mut text)?;
        if !text.next_line() {
            break;
        }
    }
    Ok(())
}

/// How many lines of each kind there are: known beforehand, an index can be refused at its own line, and nothing is reserved
/// in vain.
#[derive(Default)]
struct Lines {
    vertices: usize,
    faces: usize,
}

impl Lines {
    fn count(bytes: &[u8]) -> Self {
        let mut lines = Self::default();
        // Cannot fail, since the visitor does not.
        let _ = each_line(bytes, |keyword, _| {
            match keyword {
                b"v" => lines.vertices += 1,
                b"f" | b"fo" => lines.faces += 1,
                _ => {}
            }
            Ok(())
        });
        lines
    }
}

fn vertex(text: &mut Text<'_>, before: usize) -> Result<DVec3, Fault> {
    if before >= u32::MAX as usize {
        return Err(Fault::line(text.line(), Cause::TooManyVertices));
    }
    let x = text.number("the x coordinate of a vertex")?;
    let y = text.number("the y coordinate of a vertex")?;
    let z = text.number("the z coordinate of a vertex")?;
    Ok(DVec3::new(x, y, z))
}

/// Reads the corners of a face that follows `before` of all `vertices`.
fn face(text: &mut Text<'_>, before: usize, vertices: usize, corners: &mut Vec<u32>) -> Result<(), Fault> {
    corners.clear();
    while let Some(word) = text.word() {
        let digits = word.split(|byte| *byte == b'/').next().unwrap_or_default();
        if !is_integer(digits) {
            return Err(text.unexpected("a vertex index", word));
        }
        let (from_zero, vertices) = match integer(digits) {
            Some(index @ 1..) => (Some(index - 1), vertices),
            Some(index) if index < 0 => (index.checked_add_unsigned(before as u64), before),
            _ => (None, vertices),
        };
        let corner = from_zero.and_then(|corner| u32::try_from(corner).ok());
        match corner.filter(|corner| (*corner as usize) < vertices) {
            Some(corner) => corners.push(corner),
            None => {
                let cause = Cause::IndexOutOfRange { index: shown(digits), vertices: vertices as u64 };
                return Err(Fault::line(text.line(), cause));
            }
        }
    }
    Ok(())
}

/// Digits with at most a sign, whether or not they fit.
fn is_integer(word: &[u8]) -> bool {
    let digits = word.strip_prefix(b"-").unwrap_or(word);
    !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}

#[cfg(test)]
mod tests {
    use super::super::error::Place;
    use super::*;

    fn fails(text: &str) -> (Place, Cause) {
        let fault = parse(text.as_bytes()).unwrap_err();
        (fault.place, fault.cause)
    }

    #[test]
    fn polygons_negative_indices_and_slashes() {
        let mesh = parse(b"v 0 0 0\nv 1 0 0 1\nv 1 1 0 .5 .5 .5\nv 0 1 0\nf 1/1/1 2//2 3/3 4\nf -4 -3 -2\n").unwrap();
        assert_eq!(mesh.positions.len(), 4);
        assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    }

    #[test]
    fn continuations_tabs_and_no_last_newline() {
        let mesh = parse(b"v\t0 0 0\r\nv 1 0\\\r\n 0\r\nv 0 1 0 1.0\r\nf 1//  2// \\\r\n 3//").unwrap();
        assert_eq!(mesh.positions[1], DVec3::X);
        assert_eq!(mesh.faces, [[0, 1, 2]]);
    }

    #[test]
    fn short_faces_are_skipped_and_faces_may_come_first() {
        let mesh = parse(b"f 1 2\nf 1\nf\nf 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\np 1").unwrap();
        assert_eq!(mesh.faces, [[0, 1, 2]]);
    }

    #[test]
    fn errors_name_the_line() {
        let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let out = |index: &str| Cause::IndexOutOfRange { index: index.into(), vertices: 3 };
        assert_eq!(fails(&format!("{three}f 1 2 0")), (Place::Line(4), out("0")));
        assert_eq!(fails(&format!("{three}\nf 1 2 4\n")), (Place::Line(5), out("4")));
        assert_eq!(fails(&format!("{three}f -1 -2 -4")), (Place::Line(4), out("-4")));
        let huge = "99999999999999999999";
        assert_eq!(fails(&format!("{three}f 1 2 {huge}")), (Place::Line(4), out(huge)));
        assert_eq!(fails("v 0 0\n").0, Place::Line(1));
        let found = Cause::Unexpected { expected: "the y coordinate of a vertex", found: "1,5".into() };
        assert_eq!(fails("# a\nv 0 1,5 0"), (Place::Line(2), found));
        assert_eq!(fails("f ish").0, Place::Line(1));
        assert!(matches!(fails("hello\nworld").1, Cause::NothingFound(_)));
        assert!(matches!(fails("").1, Cause::NothingFound(_)));
    }

    #[test]
    fn utf16_is_decoded() {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let bytes: Vec<u8> = [0xfe, 0xff].into_iter().chain(text.bytes().flat_map(|b| [0, b])).collect();
        assert_eq!(parse(&bytes).unwrap().faces, [[0, 1, 2]]);
    }
}
