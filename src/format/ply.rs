//! Stanford PLY: the header, and how its elements become a mesh.

use glam::DVec3;

use super::error::{Cause, Fault, shown};
use super::ply_values::{Binary, Scalar, Values, Written};
use super::strip::push_strip;
use super::text::{Text, integer};
use crate::surface::TriangleMesh;

/// Reads the positions and faces of an ASCII or binary PLY file of either byte order.
///
/// Any scalar types, extra properties and extra elements are accepted. Polygons become fans, `tristrips` are expanded;
/// faces with fewer than three corners are skipped.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleMesh, Fault> {
    let header = Header::parse(bytes)?;
    let body = &bytes[header.length..];
    match header.encoding {
        Encoding::Text => read(&header, Written::new(Text::new(body).starting_at(header.lines + 1))),
        Encoding::LittleEndian => read(&header, Binary::new(bytes, header.length, false)),
        Encoding::BigEndian => read(&header, Binary::new(bytes, header.length, true)),
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
    /// Declared vertices; faces are checked against this, wherever they stand.
    vertices: u64,
    /// Bytes of the header.
    length: usize,
    /// Lines of the header.
    lines: u64,
}

/// Rows of equal make-up.
struct Element {
    kind: Kind,
    count: u64,
    properties: Vec<Property>,
    line: u64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Vertices,
    Faces,
    Strips,
    Other,
}

struct Property {
    role: Role,
    /// The type of a list's length, if it is a list.
    length: Option<Scalar>,
    /// The type of the value, or of a list's values.
    value: Scalar,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Coordinate(usize),
    Corners,
    Other,
}

impl Header {
    fn parse(bytes: &[u8]) -> Result<Self, Fault> {
        let mut text = Text::new(bytes);
        if text.word() != Some(b"ply") {
            return Err(Fault::line(1, Cause::NothingFound("it does not begin with `ply`")));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            if !text.next_line() {
                return Err(Fault::line(text.line(), Cause::EndsEarly("the header")));
            }
            match text.word() {
                Some(b"format") => encoding = Some(Encoding::parse(&mut text)?),
                Some(b"element") => elements.push(Element::parse(&mut text)?),
                Some(b"property") => {
                    let property = Property::parse(&mut text)?;
                    let element = elements.last_mut();
                    let stray = || text.unexpected("an `element` line first", b"property");
                    element.ok_or_else(stray)?.properties.push(property);
                }
                Some(b"end_header") => break,
                Some(b"comment" | b"obj_info") | None => {}
                Some(other) => return Err(text.unexpected("a header line", other)),
            }
        }
        let encoding = encoding.ok_or_else(|| Fault::line(text.line(), Cause::Missing("the `format` line")))?;
        let length = header_length(bytes, text.offset());
        let vertices = vertex_count(&elements, text.line())?;
        Ok(Self { encoding, vertices, elements, length, lines: text.line() })
    }
}

/// Checks the vertex element and gives its count.
fn vertex_count(elements: &[Element], last_line: u64) -> Result<u64, Fault> {
    let mut all = elements.iter().filter(|element| element.kind == Kind::Vertices);
    let Some(element) = all.next() else {
        return Err(Fault::line(last_line, Cause::Missing("the `vertex` element")));
    };
    if let Some(second) = all.next() {
        return Err(Fault::line(second.line, Cause::Invalid("there is a second `vertex` element".to_owned())));
    }
    for (axis, name) in ["property `x`", "property `y`", "property `z`"].into_iter().enumerate() {
        if !element.properties.iter().any(|property| property.role == Role::Coordinate(axis)) {
            return Err(Fault::line(element.line, Cause::Missing(name)));
        }
    }
    if element.count > u64::from(u32::MAX) {
        return Err(Fault::line(element.line, Cause::TooManyVertices));
    }
    Ok(element.count)
}

/// Where the body starts, given where `end_header` ends.
///
/// After a header whose lines end with a lone CR, a following LF already belongs to the body.
fn header_length(bytes: &[u8], mut at: usize) -> usize {
    let lone_returns = bytes.get(3) == Some(&b'\r') && bytes.get(4) != Some(&b'\n');
    while matches!(bytes.get(at), Some(b' ' | b'\t')) {
        at += 1;
    }
    let end = match bytes.get(at..) {
        Some([b'\r', b'\n', ..]) if !lone_returns => 2,
        Some([b'\r' | b'\n', ..]) => 1,
        _ => 0,
    };
    at + end
}

impl Encoding {
    fn parse(text: &mut Text<'_>) -> Result<Self, Fault> {
        match text.word() {
            Some(b"ascii") => Ok(Self::Text),
            Some(b"binary_little_endian") => Ok(Self::LittleEndian),
            Some(b"binary_big_endian") => Ok(Self::BigEndian),
            Some(other) => {
                let expected = "`ascii`, `binary_little_endian` or `binary_big_endian`";
                Err(text.unexpected(expected, other))
            }
            None => Err(Fault::line(text.line(), Cause::Missing("the encoding"))),
        }
    }
}

impl Element {
    fn parse(text: &mut Text<'_>) -> Result<Self, Fault> {
        let kind = match text.word() {
            Some(b"vertex") => Kind::Vertices,
            Some(b"face") => Kind::Faces,
            Some(b"tristrips") => Kind::Strips,
            Some(_) => Kind::Other,
            None => return Err(Fault::line(text.line(), Cause::Missing("the element's name"))),
        };
        let word = text.word().ok_or_else(|| Fault::line(text.line(), Cause::Missing("the element's count")))?;
        let count = integer(word).and_then(|count| u64::try_from(count).ok());
        let count = count.ok_or_else(|| text.unexpected("the element's count", word))?;
        Ok(Self { kind, count, properties: Vec::new(), line: text.line() })
    }
}

impl Property {
    fn parse(text: &mut Text<'_>) -> Result<Self, Fault> {
        let kind = |text: &mut Text<'_>| match text.word() {
            Some(word) => Scalar::parse(word).ok_or_else(|| text.unexpected("a type such as `float`", word)),
            None => Err(Fault::line(text.line(), Cause::Missing("the property's type"))),
        };
        let first = text.word().ok_or_else(|| Fault::line(text.line(), Cause::Missing("the property's type")))?;
        let (length, value) = if first == b"list" {
            let length = kind(text)?;
            if length.is_float() {
                return Err(text.unexpected("a whole type for a list's length", b"float"));
            }
            (Some(length), kind(text)?)
        } else {
            let value = Scalar::parse(first);
            (None, value.ok_or_else(|| text.unexpected("a type such as `float`", first))?)
        };
        let name = text.word().ok_or_else(|| Fault::line(text.line(), Cause::Missing("the property's name")))?;
        let role = match (name, length) {
            (b"x", None) => Role::Coordinate(0),
            (b"y", None) => Role::Coordinate(1),
            (b"z", None) => Role::Coordinate(2),
            (b"vertex_indices" | b"vertex_index", Some(_)) => Role::Corners,
            _ => Role::Other,
        };
        Ok(Self { role, length, value })
    }
}

fn read<V: Values>(header: &Header, mut values: V) -> Result<TriangleMesh, Fault> {
    let mut mesh = TriangleMesh::default();
    for element in &header.elements {
        if element.properties.is_empty() {
            continue;
        }
        check_room(element, &values)?;
        match element.kind {
            Kind::Vertices => read_vertices(element, &mut values, &mut mesh)?,
            Kind::Faces => {
                mesh.faces.reserve_exact(element.count as usize);
                read_corners(element, header.vertices, &mut values, |corners| mesh.push_polygon(corners))?;
            }
            Kind::Strips => {
                read_corners(element, header.vertices, &mut values, |corners| push_strips(&mut mesh, corners))?;
            }
            Kind::Other => read_corners(element, header.vertices, &mut values, |_| ())?,
        }
    }
    Ok(mesh)
}

/// Refuses counts that the rest of the file cannot hold, before anything is reserved for them.
fn check_room<V: Values>(element: &Element, values: &V) -> Result<(), Fault> {
    let row: u64 =
        element.properties.iter().map(|property| V::least_bytes(property.length.unwrap_or(property.value))).sum();
    let room = values.room();
    if element.count.checked_mul(row).is_some_and(|bytes| bytes <= room + V::SLACK) {
        return Ok(());
    }
    let what = match element.kind {
        Kind::Vertices => "vertices",
        Kind::Faces => "faces",
        Kind::Strips | Kind::Other => "rows of an element",
    };
    Err(values.fault(Cause::CountTooLarge { what, count: element.count, room }))
}

fn read_vertices<V: Values>(element: &Element, values: &mut V, mesh: &mut TriangleMesh) -> Result<(), Fault> {
    mesh.positions.reserve_exact(element.count as usize);
    for _ in 0..element.count {
        let mut position = DVec3::NAN;
        values.begin_row("the vertices")?;
        for property in &element.properties {
            match (property.role, property.length) {
                (Role::Coordinate(axis), _) => position[axis] = values.scalar(property.value)?,
                (_, None) => drop(values.scalar(property.value)?),
                (_, Some(length)) => drop(read_list(values, length, property.value, |_, _| Ok(()))?),
            }
        }
        values.end_row();
        mesh.positions.push(position);
    }
    Ok(())
}

/// Reads the rows of an element and hands the corners in each to `take`; −1 parts strips and comes as `u32::MAX`.
fn read_corners<V: Values>(
    element: &Element,
    vertices: u64,
    values: &mut V,
    mut take: impl FnMut(&[u32]),
) -> Result<(), Fault> {
    let strips = element.kind == Kind::Strips;
    let wanted = matches!(element.kind, Kind::Faces | Kind::Strips);
    let mut corners = Vec::new();
    for _ in 0..element.count {
        corners.clear();
        values.begin_row("the faces")?;
        for property in &element.properties {
            let Some(length) = property.length else {
                values.scalar(property.value)?;
                continue;
            };
            let keep = wanted && property.role == Role::Corners;
            read_list(values, length, property.value, |values, index| {
                if keep {
                    corners.push(corner(values, index, vertices, strips)?);
                }
                Ok(())
            })?;
        }
        values.end_row();
        take(&corners);
    }
    Ok(())
}

fn corner<V: Values>(values: &V, index: f64, vertices: u64, strips: bool) -> Result<u32, Fault> {
    if index >= 0.0 && index < vertices as f64 && index.fract() == 0.0 {
        return Ok(index as u32);
    }
    if strips && index == -1.0 {
        return Ok(u32::MAX);
    }
    Err(values.fault(Cause::IndexOutOfRange { index: index.to_string(), vertices }))
}

/// Reads a list and hands each value to `take`.
fn read_list<V: Values>(
    values: &mut V,
    length: Scalar,
    value: Scalar,
    mut take: impl FnMut(&V, f64) -> Result<(), Fault>,
) -> Result<(), Fault> {
    let count = values.scalar(length)?;
    if !(count >= 0.0 && count.fract() == 0.0) {
        let found = shown(count.to_string().as_bytes());
        return Err(values.fault(Cause::Unexpected { expected: "the length of a list", found }));
    }
    let room = values.room();
    if count * V::least_bytes(value) as f64 > (room + V::SLACK) as f64 {
        return Err(values.fault(Cause::CountTooLarge { what: "values of a list", count: count as u64, room }));
    }
    for _ in 0..count as u64 {
        let item = values.scalar(value)?;
        take(values, item)?;
    }
    Ok(())
}

fn push_strips(mesh: &mut TriangleMesh, corners: &[u32]) {
    for strip in corners.split(|corner| *corner == u32::MAX) {
        push_strip(&mut mesh.faces, strip);
    }
}

#[cfg(test)]
mod tests {
    use super::super::error::Place;
    use super::*;

    const TRIANGLES: &str = "element vertex 4\nproperty float x\nproperty double y\nproperty int8 z\n\
        property list uchar short w\nelement face 2\nproperty uchar c\nproperty list uchar int vertex_index\nend_header\n";

    fn ascii(body: &str) -> Vec<u8> {
        format!("ply\nformat ascii 1.0\ncomment x\n{TRIANGLES}{body}").into_bytes()
    }

    /// The same square in binary; the second face is a quadrilateral.
    fn binary(big: bool) -> Vec<u8> {
        let name = if big { "big" } else { "little" };
        let mut bytes =
            format!("ply\r\nformat binary_{name}_endian 1.0\r\n{}", TRIANGLES.replace('\n', "\r\n")).into_bytes();
        let mut put =
            |value: &[u8]| bytes.extend(value.iter().rev().filter(|_| big).chain(value.iter().filter(|_| !big)));
        for (x, y) in [(0.0f32, 0.0f64), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
            put(&[255]);
            put(&[1]);
            put(&7i16.to_le_bytes());
        }
        for face in [&[0i32, 1, 2][..], &[0, 1, 2, 3]] {
            put(&[9]);
            put(&[face.len() as u8]);
            face.iter().for_each(|index| put(&index.to_le_bytes()));
        }
        bytes
    }

    #[test]
    fn all_encodings_agree() {
        let text = parse(&ascii("0 0 -1 1 7\n1 0 -1 0\n\n1 1 -1 0\n0 1 -1 2 3 4\n9 3 0 1 2\n9 4 0 1 2 3")).unwrap();
        assert_eq!(text.positions[2], DVec3::new(1.0, 1.0, -1.0));
        assert_eq!(text.faces, [[0, 1, 2], [0, 1, 2], [0, 2, 3]]);
        assert_eq!(parse(&binary(false)).unwrap(), text);
        assert_eq!(parse(&binary(true)).unwrap(), text);
    }

    #[test]
    fn strips_are_expanded() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
            element tristrips 1\nproperty list int int vertex_indices\nend_header\n\
            0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 3 2 1\n";
        assert_eq!(parse(text.as_bytes()).unwrap().faces, [[0, 1, 2], [1, 3, 2], [3, 2, 1]]);
    }

    #[test]
    fn errors_name_line_and_byte() {
        let fails = |bytes: &[u8]| parse(bytes).unwrap_err();
        assert_eq!(fails(&ascii("0 0 0 0\n1 0 x 0\n0 0 0 0\n0 0 0 0\n9 3 0 1 2\n9 3 0 1 2\n")).place, Place::Line(14));
        let fault = fails(&ascii("0 0 0 0\n1 0 0 0\n0 0 0 0\n0 0 0 0\n9 3 0 1 4\n9 3 0 1 2\n"));
        assert_eq!(fault.place, Place::Line(17));
        assert_eq!(fault.cause, Cause::IndexOutOfRange { index: "4".into(), vertices: 4 });
        let good = binary(false);
        let mut bad = good.clone();
        let at = good.len() - 4;
        bad[at] = 77;
        assert_eq!(fails(&bad).place, Place::Byte(at as u64));
        let cut = fails(&good[..good.len() - 1]);
        assert_eq!(cut.place, Place::Byte(good.len() as u64 - 17));
        assert!(matches!(cut.cause, Cause::CountTooLarge { what: "values of a list", count: 4, room: 15 }));
    }

    #[test]
    fn broken_headers_are_refused() {
        let cause = |text: &str| parse(text.as_bytes()).unwrap_err().cause;
        assert!(matches!(cause(""), Cause::NothingFound(_)));
        assert!(matches!(cause("ply\nformat ascii 1.0\n"), Cause::EndsEarly(_)));
        assert!(matches!(cause("ply\nproperty float x\nend_header\n"), Cause::Unexpected { .. }));
        assert!(matches!(cause("ply\nformat ascii 1.0\nend_header\n"), Cause::Missing(_)));
        let vertices = |count: &str| {
            format!(
                "ply\nformat binary_little_endian 1.0\nelement vertex {count}\nproperty float x\n\
                property float y\nproperty float z\nend_header\n"
            )
        };
        assert!(matches!(cause(&vertices("4000000000")), Cause::CountTooLarge { .. }));
        assert!(matches!(cause(&vertices("-1")), Cause::Unexpected { .. }));
        let idle = vertices("0").replace("end_header", "element nothing 9999999999999999\nend_header");
        assert!(parse(idle.as_bytes()).is_ok());
    }
}
