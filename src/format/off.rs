//! Object File Format (OFF), as text.

use glam::DVec3;

use super::error::{Cause, Fault, shown};
use super::text::{Text, decoded, integer};
use crate::surface::TriangleMesh;

/// The shortest line that a vertex or a face can have: three one-digit numbers and an end.
const SHORTEST_LINE: u64 = 6;

/// Reads the positions and faces of an OFF file; normals, colours and texture coordinates are skipped.
///
/// One vertex or face a line, `#` begins a comment, the counts stand on the line of the keyword or after it. Polygons
/// become fans; faces with fewer than three corners are skipped.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, Fault> {
    let decoded = decoded(bytes);
    let mut text = Text::new(&decoded).with_comments();
    keyword(&mut text)?;
    let (vertices, faces) = counts(&mut text)?;
    let mut mesh = TriangleMesh { positions: Vec::with_capacity(vertices), faces: Vec::with_capacity(faces) };
    for _ in 0..vertices {
        to_content(&mut text, "the vertices")?;
        let x = text.number("the x coordinate of a vertex")?;
        let y = text.number("the y coordinate of a vertex")?;
        let z = text.number("the z coordinate of a vertex")?;
        mesh.positions.push(DVec3::new(x, y, z));
        text.next_line();
    }
    let mut corners = Vec::new();
    for _ in 0..faces {
        to_content(&mut text, "the faces")?;
        face(&mut text, vertices, &mut corners)?;
        mesh.push_polygon(&corners);
        text.next_line();
    }
    Ok(mesh)
}

/// Reads `OFF`, `COFF`, `STNOFF` and the like.
fn keyword(text: &mut Text<'_>) -> Result<(), Fault> {
    let nothing = Cause::NothingFound("it does not begin with `OFF`");
    let word = text.word_anywhere().ok_or_else(|| Fault::line(1, nothing.clone()))?;
    let prefix = word.strip_suffix(b"OFF").ok_or_else(|| Fault::line(text.line(), nothing))?;
    if !matches!(prefix, b"" | b"C" | b"N" | b"ST" | b"CN" | b"STC" | b"STN" | b"STCN") {
        let remedy = "export it with three coordinates a vertex, as plain OFF";
        return Err(Fault::line(text.line(), Cause::Unsupported { what: format!("`{}`", shown(word)), remedy }));
    }
    Ok(())
}

/// Reads how many vertices and faces there are, and checks that the rest of the file can hold so many.
fn counts(text: &mut Text<'_>) -> Result<(usize, usize), Fault> {
    to_content(text, "the header")?;
    let vertices = match text.word() {
        Some(b"BINARY") => {
            let what = "binary OFF".to_owned();
            let remedy = "export it as text, or as binary PLY";
            return Err(Fault::line(text.line(), Cause::Unsupported { what, remedy }));
        }
        Some(word) => integer(word)
            .and_then(|count| u64::try_from(count).ok())
            .ok_or_else(|| text.unexpected("the number of vertices", word))?,
        None => return Err(Fault::line(text.line(), Cause::Missing("the number of vertices"))),
    };
    let faces = text.count("the number of faces")?;
    let line = text.line();
    text.next_line();
    let room = text.room() as u64;
    let too_large = |what, count| Fault::line(line, Cause::CountTooLarge { what, count, room });
    // The last line may lack its end.
    let most = (room + 1) / SHORTEST_LINE;
    if vertices > most {
        return Err(too_large("vertices", vertices));
    }
    // A face may be as short as `0` and a line end.
    if faces > room.div_ceil(2) {
        return Err(too_large("faces", faces));
    }
    if vertices > u64::from(u32::MAX) {
        return Err(Fault::line(line, Cause::TooManyVertices));
    }
    Ok((vertices as usize, faces as usize))
}

/// Goes to the next word, over empty lines and comments.
fn to_content(text: &mut Text<'_>, part: &'static str) -> Result<(), Fault> {
    if text.seek_word() { Ok(()) } else { Err(Fault::line(text.line(), Cause::EndsEarly(part))) }
}

/// Reads the corners of one face.
fn face(text: &mut Text<'_>, vertices: usize, corners: &mut Vec<u32>) -> Result<(), Fault> {
    corners.clear();
    let count = text.count("the number of corners of a face")?;
    for _ in 0..count {
        let word = text.word().ok_or_else(|| Fault::line(text.line(), Cause::Missing("a corner of a face")))?;
        let index = integer(word).ok_or_else(|| text.unexpected("a vertex index", word))?;
        match u32::try_from(index) {
            Ok(corner) if (corner as usize) < vertices => corners.push(corner),
            _ => {
                let cause = Cause::IndexOutOfRange { index: shown(word), vertices: vertices as u64 };
                return Err(Fault::line(text.line(), cause));
            }
        }
    }
    Ok(())
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
    fn polygons_comments_and_colours() {
        let text = "# made by hand\nCOFF # colours\n\n4 2 0 # counts\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n\n1 1 0\n0 1 0\n\
                    4 0 1 2 3 255 0 0\n2 0 1";
        let mesh = parse(text.as_bytes()).unwrap();
        assert_eq!(mesh.positions[2], DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(mesh.faces, [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn counts_on_the_first_line() {
        assert_eq!(parse(b"OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap().faces, [[0, 1, 2]]);
    }

    #[test]
    fn errors_name_the_line() {
        let three = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
        let out = |index: &str| Cause::IndexOutOfRange { index: index.into(), vertices: 3 };
        assert_eq!(fails(&format!("{three}3 0 1 -1")), (Place::Line(6), out("-1")));
        assert_eq!(fails(&format!("{three}3 0 1 3")), (Place::Line(6), out("3")));
        assert_eq!(fails(&format!("{three}3 0 1")), (Place::Line(6), Cause::Missing("a corner of a face")));
        assert_eq!(fails(three), (Place::Line(6), Cause::EndsEarly("the faces")));
        assert_eq!(fails("OFF\n\n9999999999999 1 0\n0 0 0").0, Place::Line(3));
        assert!(matches!(fails("OFF\n3 99999999 0\n0 0 0\n1 0 0\n0 1 0").1, Cause::CountTooLarge { .. }));
        assert!(matches!(fails("OFF BINARY\n\0\0").1, Cause::Unsupported { .. }));
        assert!(matches!(fails("4OFF\n1 0 0\n").1, Cause::Unsupported { .. }));
        assert!(matches!(fails("prose").1, Cause::NothingFound(_)));
        assert!(matches!(fails("").1, Cause::NothingFound(_)));
    }
}
