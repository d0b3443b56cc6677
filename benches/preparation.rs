//! What does it cost to prepare a surface? Time on one and two threads, and memory beyond the input, for the largest reference
//! mesh and for a mesh four times as fine made of it.
//!
//! Wall time, the best of a few builds. Memory is counted by the allocator, over all threads. The surface has positions and
//! triangles of its own; what it takes beyond those, in the form in which meshes are usually held (three f32 a vertex and
//! three u32 a face), is in the last columns.

mod baseline;
mod common;

use baseline::mesh::Mesh;
use bevy_surface_splines::surface::{Surface, SurfaceOptions, TriangleMesh};
use common::{
    arguments::Arguments,
    clock, made,
    records::PreparationRecord,
    samples::Samples,
    table::{self, Table},
    threads,
};
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

fn main() {
    let arguments = Arguments::read();
    let samples = Samples::find(&arguments);
    let table = Table::new(&[
        "mesh",
        "faces",
        "threads",
        "build ms",
        "recorded ms",
        "baseline ms",
        "peak MB",
        "kept MB",
        "recorded peak MB",
        "peak bytes a face",
        "peak beyond f32 and u32 input, bytes a face",
        "kept beyond it, bytes a face",
    ]);
    let Some(sample) = samples.largest() else { return };
    let (name, mesh) = (sample.name, sample.mesh);
    let (memory, faces) = (sample.surface.memory(), mesh.faces.len());
    drop(sample.surface);
    let repeats = if arguments.quick { 1 } else { 3 };
    measure(&name, &mesh, samples.records.preparation(&name), repeats, &table);
    let fine = made::refined(&mesh);
    drop(mesh);
    measure(&format!("{name}, refined"), &fine, None, repeats, &table);
    println!("\nWhat a surface keeps ({name}):\n");
    let table = Table::new(&["array", "bytes a face"]);
    for array in memory.arrays {
        table.row(vec![array.name.to_owned(), format!("{:.1}", array.bytes as f64 / faces as f64)]);
    }
}

/// What a build took.
#[derive(Clone, Copy)]
struct Cost {
    ms: f64,
    /// Bytes, above what was held before.
    peak: usize,
    /// Bytes that the surface keeps.
    kept: usize,
}

fn measure(name: &str, mesh: &TriangleMesh, record: Option<PreparationRecord>, repeats: usize, table: &Table) {
    for &count in threads::COUNTS {
        let costs: Vec<Cost> = (0..repeats).map(|_| threads::on(count, || build(mesh))).collect();
        let best = costs.iter().map(|cost| cost.ms).fold(f64::INFINITY, f64::min);
        let Cost { peak, kept, .. } = costs[0];
        let one = count == threads::COUNTS[0];
        let baseline = one.then(|| clock::wall_ms(|| Mesh::new(mesh)).0);
        let record = record.filter(|_| one);
        let faces = mesh.faces.len() as f64;
        let input = (12 * mesh.positions.len() + 12 * mesh.faces.len()) as f64;
        let a_face = |bytes: f64| format!("{:.0}", bytes / faces);
        table.row([
            name.to_owned(),
            mesh.faces.len().to_string(),
            count.to_string(),
            format!("{best:.0}"),
            table::number(record.map(|record| record.ms)),
            table::number(baseline),
            format!("{:.0}", peak as f64 / 1e6),
            format!("{:.0}", kept as f64 / 1e6),
            table::number(record.map(|record| record.peak_mb)),
            a_face(peak as f64),
            a_face(peak as f64 - input),
            a_face(kept as f64 - input),
        ]);
    }
}

fn build(mesh: &TriangleMesh) -> Cost {
    MEMORY.reset_peak_usage();
    let before = MEMORY.current_usage();
    let (ms, surface) = clock::wall_ms(|| Surface::build(mesh, &SurfaceOptions::default()));
    let surface = surface.unwrap_or_else(|error| panic!("{error}"));
    let cost = Cost { ms, peak: MEMORY.peak_usage() - before, kept: MEMORY.current_usage() - before };
    drop(surface);
    cost
}
