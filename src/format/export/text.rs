//! Lines as text: OBJ and CSV.

use std::fmt::Write as _;

use super::TraceExport;

impl TraceExport {
    /// The lines as OBJ.
    pub fn to_obj(&self) -> String {
        let mut out = String::new();
        let mut first = 1;
        for trace in &self.traces {
            let name: String = trace.name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
            let _ = writeln!(out, "o {name}"); // writing to a string cannot fail
            for line in &trace.lines {
                for vertex in line {
                    let (p, n) = (vertex.position, vertex.normal);
                    let _ = writeln!(out, "v {} {} {}", p.x, p.y, p.z);
                    let _ = writeln!(out, "vt {}", vertex.distance);
                    let _ = writeln!(out, "vn {} {} {}", n.x, n.y, n.z);
                }
                out.push('l');
                for i in first..first + line.len() {
                    let _ = write!(out, " {i}/{i}");
                }
                out.push('\n');
                first += line.len();
            }
        }
        out
    }

    /// The lines as a table: a row for each vertex.
    pub fn to_csv(&self) -> String {
        let mut out = String::from("curve,line,x,y,z,normal_x,normal_y,normal_z,distance\n");
        for trace in &self.traces {
            let name = quoted(&trace.name);
            for (i, line) in trace.lines.iter().enumerate() {
                for vertex in line {
                    let (p, n, d) = (vertex.position, vertex.normal, vertex.distance);
                    let _ = writeln!(out, "{name},{i},{},{},{},{},{},{},{d}", p.x, p.y, p.z, n.x, n.y, n.z);
                }
            }
        }
        out
    }
}

/// A field of a table: in quotes where it would break the row.
fn quoted(text: &str) -> String {
    if text.contains(['"', ',', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
