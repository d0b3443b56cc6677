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
    let mut text = Text::new(&decoded).with_comments().with_continuations();
    let mut reader = Reader::default();
    loop {
        match text.word() {
            Some(b"v") => reader.vertex(&mut text)?,
            Some(b"f" | b"fo") => reader.face(&mut text)?,
            _ => {}
        }
        if !text.next_line() {
            break;
        }
    }
    reader.finish()
}

#[derive(Default)]
struct Reader {
    mesh: TriangleMesh,
    /// Corners of the face being read; kept to save allocations.
    corners: Vec<u32>,
    /// Whether any `v` or `f` line was seen.
    found: bool,
    /// The largest index that named no vertex yet, and its line.
    forward: Option<(u32, u64)>,
}

impl Reader {
    fn vertex(&mut self, text: &mut Text<'_>) -> Result<(), Fault> {
        let x = text.number("the x coordinate of a vertex")?;
        let y = text.number("the y coordinate of a vertex")?;
        let z = text.number("the z coordinate of a vertex")?;
        if self.mesh.positions.len() >= u32::MAX as usize {
            return Err(Fault::line(text.line(), Cause::TooManyVertices));
        }
        self.mesh.positions.push(DVec3::new(x, y, z));
        self.found = true;
        Ok(())
    }

    fn face(&mut self, text: &mut Text<'_>) -> Result<(), Fault> {
        self.corners.clear();
        while let Some(word) = text.word() {
            let corner = self.corner(word, text)?;
            self.corners.push(corner);
        }
        self.mesh.push_polygon(&self.corners);
        self.found = true;
        Ok(())
    }

    fn corner(&mut self, word: &[u8], text: &Text<'_>) -> Result<u32, Fault> {
        let digits = word.split(|byte| *byte == b'/').next().unwrap_or_default();
        let vertices = self.mesh.positions.len() as u64;
        let out_of_range = || Fault::line(text.line(), Cause::IndexOutOfRange { index: shown(digits), vertices });
        let index = match integer(digits) {
            Some(index) => index,
            None if is_integer(digits) => return Err(out_of_range()),
            None => return Err(text.unexpected("a vertex index", word)),
        };
        let from_zero = match index {
            1.. => index - 1,
            0 => return Err(out_of_range()),
            _ => index.checked_add_unsigned(vertices).ok_or_else(out_of_range)?,
        };
        let corner = u32::try_from(from_zero).map_err(|_| out_of_range())?;
        if u64::from(corner) >= vertices && self.forward.is_none_or(|(largest, _)| corner > largest) {
            self.forward = Some((corner, text.line()));
        }
        Ok(corner)
    }

    fn finish(self) -> Result<TriangleMesh, Fault> {
        if !self.found {
            return Err(Fault::line(1, Cause::NothingFound("no `v` and no `f` line")));
        }
        let vertices = self.mesh.positions.len();
        match self.forward {
            Some((corner, line)) if corner as usize >= vertices => {
                let index = (u64::from(corner) + 1).to_string();
                Err(Fault::line(line, Cause::IndexOutOfRange { index, vertices: vertices as u64 }))
            }
            _ => Ok(self.mesh),
        }
    }
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
