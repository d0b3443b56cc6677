//! From raw triangles to a surface: weld, sift, link, orient, order, split, measure.

use glam::DVec3;

use super::{
    BuildProgress, Bvh, Clusters, HalfEdge, SurfaceError, SurfaceReport, TriangleMesh,
    adjacency::{self, Adjacency},
    fans, metric, morton,
    options::SurfaceOptions,
    orientation,
    surface::{DROPPED, FLIPPED, Surface},
    survey::{self, UnionFind},
    weld,
};

/// Shortest admissible slack of a triangle's sides, as a share of the mean edge (see [`Surface::slack`]).
const MOLLIFICATION: f64 = 1e-5;

/// Builds a surface; O(F log F).
pub(crate) fn build(
    mesh: &TriangleMesh,
    options: &SurfaceOptions,
    progress: &BuildProgress,
) -> Result<Surface, SurfaceError> {
    check_indices(mesh)?;
    progress.step(20)?;
    let welded = weld::weld(&mesh.positions);
    progress.step(150)?;
    let corners = mesh.faces.iter().map(|t| t.map(|v| welded.of_input[v as usize]));
    let sifted = survey::sift(corners, mesh.faces.len());
    if let (true, Some(&(first, reason))) = (sifted.triangles.is_empty(), sifted.dropped.first()) {
        return Err(SurfaceError::NoUsableFaces { faces: mesh.faces.len(), first, reason });
    }
    let (min, max) = bounds(&sifted.triangles, &welded.positions);
    let diagonal = (max - min).length();
    if !(1e-60..=1e60).contains(&diagonal) || min.abs().max(max.abs()).max_element() > 1e75 {
        return Err(SurfaceError::Scale { diagonal });
    }
    progress.step(250)?;
    let mut links = adjacency::link(&sifted.triangles, &welded.positions, options)?;
    progress.step(450)?;
    let mut report = survey_links(&sifted.triangles, &links, welded.positions.len());
    let orientation = orientation::orient(&sifted.triangles, &mut links, options)?;
    progress.step(550)?;

    let order = morton::order(&sifted.triangles, &welded.positions, min, max);
    let (triangles, twins) = reorder(&sifted.triangles, &links.twins, &orientation.flip, &order);
    progress.step(700)?;
    let fans = number_by_input(fans::split(&triangles, &twins, welded.positions.len(), options)?, &order);
    let origin = origin_of(min, max);
    let positions: Vec<DVec3> = fans.welded.iter().map(|w| welded.positions[*w as usize] - origin).collect();
    progress.step(800)?;

    report.input_vertices = mesh.positions.len();
    report.input_faces = mesh.faces.len();
    report.welded_vertices = welded.positions.len();
    report.isolated_vertices = welded.positions.len() - report.isolated_vertices;
    report.split_vertices = positions.len() - (report.welded_vertices - report.isolated_vertices);
    report.degenerate_faces += sifted.dropped.iter().filter(|d| d.1 == super::DropReason::RepeatedCorner).count();
    report.duplicate_faces = sifted.duplicates;
    report.sheets = orientation.sheets;
    report.orientable = orientation.cuts == 0;
    report.consistently_oriented = orientation.consistent && report.nonmanifold_edges == 0;
    report.orientation_cuts = orientation.cuts;
    report.flipped_faces = orientation.flip.iter().filter(|f| **f).count();
    report.boundary_loops = fans::boundary_loops(&twins);
    report.diagonal = diagonal;
    report.dropped = sifted.dropped;

    let mut inner_of = vec![DROPPED; mesh.faces.len()];
    let mut outer_of = Vec::with_capacity(order.len());
    let mut sheet = Vec::with_capacity(order.len());
    for (inner, &old) in order.iter().enumerate() {
        let flip = if orientation.flip[old as usize] { FLIPPED } else { 0 };
        let face = sifted.faces[old as usize];
        inner_of[face.0 as usize] = inner as u32 | flip;
        outer_of.push(face.0 | flip);
        sheet.push(orientation.sheet[old as usize]);
    }
    let mut surface = Surface {
        bvh: Bvh::build(&positions, &fans.triangles),
        clusters: Clusters::build(&fans.triangles, &twins, &positions),
        lengths: Vec::new(),
        angle: vec![0.0; positions.len()],
        boundary: vec![false; positions.len()],
        slack: Vec::new(),
        mean_edge: Vec::new(),
        fingerprint: fingerprint(&fans.triangles, &inner_of, &positions, origin),
        triangles: fans.triangles,
        outgoing: fans.outgoing,
        positions,
        origin,
        twins,
        sheet,
        inner_of,
        outer_of,
        min,
        max,
        report,
    };
    progress.step(900)?;
    measure(&mut surface, orientation.sheets);
    progress.step(1000)?;
    Ok(surface)
}

fn check_indices(mesh: &TriangleMesh) -> Result<(), SurfaceError> {
    if mesh.faces.is_empty() {
        return Err(SurfaceError::NoFaces);
    }
    if mesh.faces.len() > 1 << 30 {
        return Err(SurfaceError::TooManyFaces { faces: mesh.faces.len() });
    }
    let vertices = mesh.positions.len();
    for (i, t) in mesh.faces.iter().enumerate() {
        if let Some(&index) = t.iter().find(|v| **v as usize >= vertices) {
            return Err(SurfaceError::IndexOutOfRange { face: super::FaceId(i as u32), index, vertices });
        }
    }
    Ok(())
}

/// Hashes the faces in input order with the positions of their vertices.
fn fingerprint(triangles: &[[u32; 3]], inner_of: &[u32], positions: &[DVec3], origin: DVec3) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut mix = |word: u64| {
        hash = (hash ^ word).wrapping_mul(0xff51_afd7_ed55_8ccd);
        hash ^= hash >> 32;
    };
    positions.iter().for_each(|p| (*p + origin).to_array().iter().for_each(|x| mix(x.to_bits())));
    for inner in inner_of {
        mix(u64::from(*inner == DROPPED));
        if let Some(t) = triangles.get((inner & !FLIPPED) as usize) {
            mix(u64::from(inner >> 31));
            t.iter().for_each(|v| mix(u64::from(*v)));
        }
    }
    hash
}

/// Where inner coordinates begin. Differences of neighbouring positions are exact, but points between them are not: a model a
/// million of its sizes away would lose seven digits of every length.
fn origin_of(min: DVec3, max: DVec3) -> DVec3 {
    const FAR: f64 = 16.0;
    let center = 0.5 * (min + max);
    if center.abs().max_element() > FAR * (max - min).length() { center } else { DVec3::ZERO }
}

fn bounds(triangles: &[[u32; 3]], positions: &[DVec3]) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    triangles.iter().flatten().map(|v| positions[*v as usize]).fold(start, |(lo, hi), p| (lo.min(p), hi.max(p)))
}

/// Counts what the mesh looked like before repair. `isolated_vertices` holds the *used* vertices until the caller turns it
/// round.
fn survey_links(triangles: &[[u32; 3]], links: &Adjacency, vertices: usize) -> SurfaceReport {
    let mut used = vec![false; vertices];
    let mut pieces = UnionFind::new(vertices);
    for t in triangles {
        t.iter().for_each(|v| used[*v as usize] = true);
        pieces.union(t[0], t[1]);
        pieces.union(t[1], t[2]);
    }
    let mut fans = UnionFind::new(triangles.len() * 3);
    let mut join = |a: HalfEdge, b: HalfEdge| {
        let origin = |h: HalfEdge| triangles[h.face() as usize][h.side()];
        let (mut c, d) = (b, b.next());
        let other = if origin(a) == origin(b) { d } else { std::mem::replace(&mut c, d) };
        fans.union(a.index() as u32, c.index() as u32);
        fans.union(a.next().index() as u32, other.index() as u32);
    };
    for (face, row) in links.twins.iter().enumerate() {
        for (k, twin) in row.iter().enumerate().filter(|(_, t)| t.is_some()) {
            join(HalfEdge::new(face as u32, k as u32), *twin);
        }
    }
    for run in &links.crowded {
        run.windows(2).for_each(|w| join(w[0], w[1]));
    }
    let mut fans_at = vec![0_u32; vertices];
    for (i, v) in triangles.iter().flatten().enumerate() {
        fans_at[*v as usize] += u32::from(fans.is_root(i as u32));
    }
    let used_count = used.iter().filter(|u| **u).count();
    SurfaceReport {
        isolated_vertices: used_count,
        components: (0..vertices as u32).filter(|v| used[*v as usize] && pieces.is_root(*v)).count(),
        boundary_edges: links.boundary_edges,
        nonmanifold_edges: links.nonmanifold_edges,
        nonmanifold_vertices: fans_at.iter().filter(|n| **n > 1).count(),
        euler_characteristic: used_count as i64 - links.edges as i64 + triangles.len() as i64,
        ..SurfaceReport::default()
    }
}

/// Turns flipped faces over and puts all into the new order. Flipping swaps the second and third corner, so that side k
/// becomes side 2 − k.
fn reorder(
    triangles: &[[u32; 3]],
    twins: &[[HalfEdge; 3]],
    flip: &[bool],
    order: &[u32],
) -> (Vec<[u32; 3]>, Vec<[HalfEdge; 3]>) {
    let mut place = vec![0_u32; triangles.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old as usize] = new as u32;
    }
    let renamed = |h: HalfEdge| {
        if !h.is_some() {
            return h;
        }
        let side = h.side() as u32;
        HalfEdge::new(place[h.face() as usize], if flip[h.face() as usize] { 2 - side } else { side })
    };
    order
        .iter()
        .map(|&old| {
            let (t, row) = (triangles[old as usize], twins[old as usize].map(renamed));
            if flip[old as usize] { ([t[0], t[2], t[1]], [row[2], row[1], row[0]]) } else { (t, row) }
        })
        .unzip()
}

/// Renumbers vertices by their first use in input order, which is what [`VertexId`](super::VertexId) promises.
fn number_by_input(mut fans: fans::Fans, order: &[u32]) -> fans::Fans {
    const UNSEEN: u32 = u32::MAX;
    let mut place = vec![0_u32; order.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old as usize] = new as u32;
    }
    let mut name = vec![UNSEEN; fans.welded.len()];
    let mut next = 0;
    for &inner in &place {
        for v in fans.triangles[inner as usize] {
            if name[v as usize] == UNSEEN {
                name[v as usize] = next;
                next += 1;
            }
        }
    }
    fans.triangles.iter_mut().flatten().for_each(|v| *v = name[*v as usize]);
    let mut welded = vec![0; fans.welded.len()];
    let mut outgoing = vec![HalfEdge::NONE; fans.outgoing.len()];
    for (old, &new) in name.iter().enumerate() {
        welded[new as usize] = fans.welded[old];
        outgoing[new as usize] = fans.outgoing[old];
    }
    fans.welded = welded;
    fans.outgoing = outgoing;
    fans
}

/// Fills in lengths, angles, boundary marks and the slack of each sheet.
fn measure(surface: &mut Surface, sheets: usize) {
    let Surface { triangles, twins, positions, lengths, angle, boundary, slack, mean_edge, sheet, report, .. } =
        surface;
    lengths.reserve_exact(triangles.len());
    let mut sums = vec![(0.0_f64, 0_usize); sheets];
    let (mut shortest, mut longest, mut smallest) = (f64::INFINITY, 0.0_f64, f64::INFINITY);
    for (face, t) in triangles.iter().enumerate() {
        let p = t.map(|v| positions[v as usize]);
        // Both faces of an edge must see the same bits, so always measure from the smaller vertex number.
        let side = |i: usize, j: usize| if t[i] < t[j] { (p[j] - p[i]).length() } else { (p[i] - p[j]).length() };
        let l = [side(0, 1), side(1, 2), side(2, 0)];
        lengths.push(l);
        for k in 0..3 {
            let corner = metric::corner_angle(l[k], l[(k + 2) % 3], l[(k + 1) % 3]);
            smallest = smallest.min(corner);
            angle[t[k] as usize] += corner;
            if !twins[face][k].is_some() {
                boundary[t[k] as usize] = true;
                boundary[t[(k + 1) % 3] as usize] = true;
            }
            shortest = shortest.min(l[k]);
            longest = longest.max(l[k]);
        }
        let side = l[0].max(l[1]).max(l[2]);
        report.degenerate_faces += usize::from(2.0 * metric::area(l[0], l[1], l[2]) <= 1e-10 * side * side);
        let sum = &mut sums[sheet[face] as usize];
        *sum = (sum.0 + l[0] + l[1] + l[2], sum.1 + 3);
    }
    mean_edge.extend(sums.iter().map(|(sum, count)| sum / (*count).max(1) as f64));
    slack.resize(sheets, 0.0);
    for (face, l) in lengths.iter().enumerate() {
        let s = sheet[face] as usize;
        let least = MOLLIFICATION * mean_edge[s];
        for k in 0..3 {
            slack[s] = slack[s].max(least - (l[k] + l[(k + 1) % 3] - l[(k + 2) % 3]));
        }
    }
    (report.shortest_edge, report.longest_edge, report.smallest_angle) = (shortest, longest, smallest);
}
