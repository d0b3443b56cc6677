//! From raw triangles to a surface: weld, sift, arrange, link, orient, split, measure.

use glam::DVec3;

use super::{
    BuildProgress, Bvh, Clusters, FaceId, HalfEdge, SurfaceError, TriangleMesh,
    adjacency::{self, Adjacency},
    arranged::Arranged,
    fans::{self, Fans},
    fingerprint::{self, Words},
    measure,
    options::SurfaceOptions,
    orientation::{self, Orientation},
    parallel::{self, PIECE},
    report::{DropReason, SurfaceReport},
    sift::{self, Sifted},
    surface::{DROPPED, FLIPPED, Surface},
    survey, weld,
};

/// Builds a surface; O(F log F). Nothing is kept longer than to the last step that needs it.
pub(crate) fn build(
    mesh: &TriangleMesh,
    options: &SurfaceOptions,
    progress: &BuildProgress,
) -> Result<Surface, SurfaceError> {
    check_indices(mesh, progress)?;
    progress.step(20)?;
    let connected = connect(mesh, options, progress)?;
    complete(connected, mesh, progress)
}

fn check_indices(mesh: &TriangleMesh, progress: &BuildProgress) -> Result<(), SurfaceError> {
    if mesh.faces.is_empty() {
        return Err(SurfaceError::NoFaces);
    }
    if mesh.faces.len() > 1 << 30 {
        return Err(SurfaceError::TooManyFaces { faces: mesh.faces.len() });
    }
    let vertices = mesh.positions.len();
    let check = |face: usize| match mesh.faces[face].iter().find(|v| **v as usize >= vertices) {
        Some(&index) => Err(SurfaceError::IndexOutOfRange { face: FaceId(face as u32), index, vertices }),
        None => Ok(()),
    };
    parallel::map_pieces(mesh.faces.len(), progress, |mut faces| faces.try_for_each(check))?.into_iter().collect()
}

/// All of a surface that is not measured.
struct Connected {
    triangles: Vec<[u32; 3]>,
    twins: Vec<[HalfEdge; 3]>,
    outgoing: Vec<HalfEdge>,
    boundary: Vec<bool>,
    positions: Vec<DVec3>,
    origin: DVec3,
    sheet: Vec<u32>,
    inner_of: Vec<u32>,
    outer_of: Vec<u32>,
    min: DVec3,
    max: DVec3,
    report: SurfaceReport,
}

/// Finds out what is where in memory and what meets what.
fn connect(mesh: &TriangleMesh, options: &SurfaceOptions, progress: &BuildProgress) -> Result<Connected, SurfaceError> {
    let welded = weld::weld(&mesh.positions, progress)?;
    progress.step(100)?;
    let sifted = sift::sift(mesh, &welded.of_input, progress)?;
    check_size(mesh, &sifted)?;
    progress.step(120)?;
    let welded_vertices = welded.first.len();
    let mut faces = Arranged::new(mesh, welded, &sifted, progress)?;
    let Sifted { kept, mut dropped, min, max } = sifted;
    drop(kept);
    progress.step(250)?;

    let (mut links, duplicates) = link_distinct(&mut faces, &mut dropped, progress)?;
    links.settle_crowded(&faces, |vertex| faces.position(mesh, vertex), options)?;
    progress.step(350)?;
    let mut inner_of = faces.inner_of(mesh.faces.len());
    let orientation = orientation::orient(&faces, &mut links, &inner_of, options, progress)?;
    orientation::turn_over(&orientation.flip, &mut faces.triangles, &mut links.twins, progress)?;
    progress.step(450)?;
    let fans = fans::split(&faces, &links.twins, &inner_of, options, progress)?;
    drop(std::mem::take(&mut faces.triangles));
    progress.step(550)?;

    let boundary = fans::boundary(&fans.outgoing, &links.twins);
    let mut report = survey::survey(&links, &orientation, &fans, faces.input_vertex.len());
    report.input_vertices = mesh.positions.len();
    report.input_faces = mesh.faces.len();
    report.welded_vertices = welded_vertices;
    report.isolated_vertices = welded_vertices - faces.input_vertex.len();
    report.degenerate_faces = dropped.iter().filter(|d| d.1 == DropReason::RepeatedCorner).count();
    report.duplicate_faces = duplicates;
    report.boundary_loops = fans::boundary_loops(&fans, &boundary);
    report.diagonal = (max - min).length();
    report.dropped = dropped;
    if report.repaired() {
        let dropped = report.dropped.iter().map(|(face, _)| *face);
        let position = |vertex| faces.position(mesh, vertex);
        report.places = survey::places(mesh, dropped, (&links, &orientation, &fans), position);
    }

    let Orientation { flip, sheet, .. } = orientation;
    mark_flipped(&flip, &mut inner_of, &mut faces.outer_of);
    let Fans { triangles, welded, outgoing } = fans;
    let origin = origin_of(min, max);
    let positions =
        parallel::table(welded.len(), DVec3::ZERO, progress, |vertex| faces.position(mesh, welded[vertex]) - origin)?;
    let twins = links.twins;
    Ok(Connected {
        triangles,
        twins,
        outgoing,
        boundary,
        positions,
        origin,
        sheet,
        inner_of,
        outer_of: faces.outer_of,
        min,
        max,
        report,
    })
}

fn check_size(mesh: &TriangleMesh, sifted: &Sifted) -> Result<(), SurfaceError> {
    if let (true, Some(&(first, reason))) = (sifted.kept.is_empty(), sifted.dropped.first()) {
        return Err(SurfaceError::NoUsableFaces { faces: mesh.faces.len(), first, reason });
    }
    let Sifted { min, max, .. } = sifted;
    let diagonal = (max - min).length();
    if !(1e-60..=1e60).contains(&diagonal) || min.abs().max(max.abs()).max_element() > 1e75 {
        return Err(SurfaceError::Scale { diagonal });
    }
    Ok(())
}

/// Links sides, after dropping faces that are there already; also tells how many had the corners of an earlier one.
fn link_distinct(
    faces: &mut Arranged,
    dropped: &mut Vec<(FaceId, DropReason)>,
    progress: &BuildProgress,
) -> Result<(Adjacency, usize), SurfaceError> {
    let vertices = faces.input_vertex.len();
    let links = adjacency::link(&faces.triangles, vertices, progress)?;
    let copies = sift::copies(&mut links.copies(&faces.triangles), &faces.triangles, &faces.outer_of);
    if copies.superfluous.is_empty() {
        return Ok((links, copies.duplicates));
    }
    drop(links);
    let outer = |face: &u32| FaceId(faces.outer_of[*face as usize]);
    dropped.extend(copies.superfluous.iter().map(|face| (outer(face), DropReason::Duplicate)));
    dropped.sort_unstable_by_key(|d| d.0);
    faces.retain(|face| !copies.superfluous.contains(&face));
    Ok((adjacency::link(&faces.triangles, vertices, progress)?, copies.duplicates))
}

fn mark_flipped(flip: &[bool], inner_of: &mut [u32], outer_of: &mut [u32]) {
    for (inner, outer) in outer_of.iter_mut().enumerate().filter(|(inner, _)| flip[*inner]) {
        inner_of[*outer as usize] = inner as u32 | FLIPPED;
        *outer |= FLIPPED;
    }
}

/// Where inner coordinates begin. Differences of neighbouring positions are exact, but points between them are not: a model a
/// million of its sizes away would lose seven digits of every length.
fn origin_of(min: DVec3, max: DVec3) -> DVec3 {
    const FAR: f64 = 16.0;
    let center = 0.5 * (min + max);
    if center.abs().max_element() > FAR * (max - min).length() { center } else { DVec3::ZERO }
}

/// Measures what is connected.
fn complete(parts: Connected, mesh: &TriangleMesh, progress: &BuildProgress) -> Result<Surface, SurfaceError> {
    // The tree takes more memory while it is built than all that comes after it.
    let (bvh, (hashes, clusters)) = parallel::join(
        || Bvh::build(&parts.positions, &parts.triangles, progress),
        || {
            let hashes = identity(&parts, progress).and_then(|it| Ok((it, fingerprint::of(mesh, progress)?)));
            (hashes, Clusters::build(&parts.triangles, &parts.twins, &parts.positions, progress))
        },
    );
    let (bvh, (identity, fingerprint), clusters) = (bvh?, hashes?, clusters?);
    progress.step(850)?;
    let lengths = measure::lengths(&parts.triangles, &parts.positions, progress)?;
    progress.step(900)?;
    let (angles, (sheets, extremes)) = parallel::join(
        || measure::angles(&parts.triangles, &lengths, parts.positions.len(), progress),
        || {
            parallel::join(
                || measure::sheets(&lengths, &parts.sheet, parts.report.sheets, progress),
                || measure::extremes(&lengths, progress),
            )
        },
    );
    let ((angle, smallest_angle), sheets, extremes) = (angles?, sheets?, extremes?);
    let report = SurfaceReport {
        degenerate_faces: parts.report.degenerate_faces + extremes.degenerate,
        shortest_edge: extremes.shortest,
        longest_edge: extremes.longest,
        smallest_angle,
        ..parts.report
    };
    progress.step(1000)?;
    Ok(Surface {
        triangles: parts.triangles,
        twins: parts.twins,
        lengths,
        positions: parts.positions,
        origin: parts.origin,
        outgoing: parts.outgoing,
        angle,
        boundary: parts.boundary,
        sheet: parts.sheet,
        slack: sheets.slack,
        mean_edge: sheets.mean_edge,
        inner_of: parts.inner_of,
        outer_of: parts.outer_of,
        identity,
        fingerprint,
        min: parts.min,
        max: parts.max,
        report,
        bvh,
        clusters,
    })
}

/// Hashes the faces in input order with the positions of their vertices.
fn identity(parts: &Connected, progress: &BuildProgress) -> Result<u64, SurfaceError> {
    let mut hash = Words::default();
    let mut mix = |word: u64| hash.mix(word);
    for positions in parts.positions.chunks(PIECE) {
        progress.check()?;
        positions.iter().for_each(|p| (*p + parts.origin).to_array().iter().for_each(|x| mix(x.to_bits())));
    }
    for faces in parts.inner_of.chunks(PIECE) {
        progress.check()?;
        for inner in faces {
            mix(u64::from(*inner == DROPPED));
            if let Some(t) = parts.triangles.get((inner & !FLIPPED) as usize) {
                mix(u64::from(inner >> 31));
                t.iter().for_each(|v| mix(u64::from(*v)));
            }
        }
    }
    Ok(hash.0)
}
