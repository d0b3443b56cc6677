//! What was found in a mesh, and what was done about it.

use std::fmt;

use glam::DVec3;

use super::FaceId;

/// Why an input face is not part of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub enum DropReason {
    /// A corner has a NaN or infinite coordinate.
    #[error("one of its corners is not a finite position")]
    NotFinite,
    /// Two corners are the same place.
    #[error("two of its corners are the same place")]
    RepeatedCorner,
    /// An earlier face has the same corners in the same order.
    #[error("an earlier face has the same corners")]
    Duplicate,
}

/// Something that was done to a mesh at some place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub enum Repair {
    /// A face was dropped: its middle, where it has one.
    #[error("face dropped")]
    Dropped,
    /// A face was turned over: its middle.
    #[error("face turned over")]
    Flipped,
    /// An edge has three faces or more: its middle.
    #[error("edge of three faces or more")]
    NonManifoldEdge,
    /// An edge was cut because its faces could not be made to agree: its middle.
    #[error("edge cut to orient")]
    Cut,
    /// A vertex was split: its place.
    #[error("vertex split")]
    Split,
}

/// What was found in a mesh, and what was done about it.
///
/// Counts are of the mesh as it came, after exact welding, unless they say otherwise.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct SurfaceReport {
    /// Vertices given.
    pub input_vertices: usize,
    /// Faces given.
    pub input_faces: usize,
    /// Distinct finite positions, used by a face or not.
    pub welded_vertices: usize,
    /// Distinct finite positions that no face uses.
    pub isolated_vertices: usize,
    /// Faces that were dropped, in order, with the reason.
    pub dropped: Vec<(FaceId, DropReason)>,
    /// Where something was done, and what; the first [`SurfaceReport::MOST_PLACES`] of each kind.
    pub places: Vec<(Repair, DVec3)>,
    /// Faces with a repeated corner, or with no area to speak of (twice the area ≤ 1e-10 · longest side²); the latter are
    /// kept.
    pub degenerate_faces: usize,
    /// Faces whose three corners an earlier face has too, in whatever order.
    pub duplicate_faces: usize,
    /// Pieces joined by shared vertices.
    pub components: usize,
    /// Pieces joined by sides after repair: shortest paths exist within one of these.
    pub sheets: usize,
    /// Edges with one face.
    pub boundary_edges: usize,
    /// Closed chains of boundary edges, after repair.
    pub boundary_loops: usize,
    /// Edges with three or more faces; what was done with them is for the options to say.
    pub nonmanifold_edges: usize,
    /// Vertices whose faces are not one fan; each was split.
    pub nonmanifold_vertices: usize,
    /// Vertices added by splitting.
    pub split_vertices: usize,
    /// Whether the faces could be turned so that neighbours agree.
    pub orientable: bool,
    /// Whether neighbours agreed as given, everywhere: at an edge with three faces they cannot.
    pub consistently_oriented: bool,
    /// Faces turned over so that neighbours agree.
    pub flipped_faces: usize,
    /// Edges cut because their faces could not be made to agree.
    pub orientation_cuts: usize,
    /// Vertices − edges + faces.
    pub euler_characteristic: i64,
    /// Shortest edge.
    pub shortest_edge: f64,
    /// Longest edge.
    pub longest_edge: f64,
    /// Smallest corner angle, in radians.
    pub smallest_angle: f64,
    /// Length of the bounding box's diagonal.
    pub diagonal: f64,
}

impl SurfaceReport {
    /// At most so many places of each kind are kept.
    pub const MOST_PLACES: usize = 256;

    /// Whether building changed anything: faces dropped, flipped or cut apart.
    pub fn repaired(&self) -> bool {
        !self.dropped.is_empty()
            || self.flipped_faces > 0
            || self.orientation_cuts > 0
            || self.nonmanifold_edges > 0
            || self.split_vertices > 0
    }

    /// Whether no edge had a single face, as the mesh came; repairs that cut it open show in `boundary_loops`.
    pub fn is_closed(&self) -> bool {
        self.boundary_edges == 0
    }
}

impl fmt::Display for SurfaceReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let faces = self.input_faces.saturating_sub(self.dropped.len());
        let vertices = self.welded_vertices.saturating_sub(self.isolated_vertices).saturating_add(self.split_vertices);
        write!(f, "{faces} faces, {vertices} vertices")?;
        let mut note = |count: usize, what: &str| if count > 0 { write!(f, ", {count} {what}") } else { Ok(()) };
        note(self.dropped.len(), "faces dropped")?;
        note(self.degenerate_faces, "degenerate faces")?;
        note(self.duplicate_faces, "duplicate faces")?;
        note(self.boundary_loops, "boundary loops")?;
        note(self.nonmanifold_edges, "non-manifold edges")?;
        note(self.split_vertices, "vertices added by splitting")?;
        note(self.flipped_faces, "faces turned over")?;
        note(self.orientation_cuts, "edges cut to orient")?;
        note(if self.sheets > 1 { self.sheets } else { 0 }, "separate sheets")
    }
}

/// Why no surface could be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// There are no faces at all.
    #[error("the mesh has no faces: give at least one triangle")]
    NoFaces,
    /// Every face had to be dropped.
    #[error("none of the {faces} faces can be used; {first} was dropped: {reason}")]
    NoUsableFaces {
        /// How many faces were given.
        faces: usize,
        /// The first of them.
        first: FaceId,
        /// Why the first was dropped.
        reason: DropReason,
    },
    /// A face names a vertex that does not exist.
    #[error("{face} uses vertex {index}, but there are {vertices} vertices: correct the index")]
    IndexOutOfRange {
        /// The face.
        face: FaceId,
        /// The index it uses.
        index: u32,
        /// How many vertices were given.
        vertices: usize,
    },
    /// The mesh is too large or too small for 64-bit arithmetic of fourth powers.
    #[error("the mesh's bounding box has diagonal {diagonal:e}: scale it into 1e-60 to 1e60")]
    Scale {
        /// Length of the bounding box's diagonal.
        diagonal: f64,
    },
    /// More faces than the packed indices can count.
    #[error("{faces} faces are more than the 2^30 that a surface can hold: split the mesh")]
    TooManyFaces {
        /// How many faces were given.
        faces: usize,
    },
    /// A non-manifold edge, and the options ask to refuse those.
    #[error("{face} has an edge with {count} faces; use the policy `Cut` to open it")]
    NonManifoldEdge {
        /// One of the faces.
        face: FaceId,
        /// How many faces meet in the edge.
        count: usize,
    },
    /// A non-manifold vertex, and the options ask to refuse those.
    #[error("{face} has a corner where {fans} fans of faces meet; use the policy `Split` to part them")]
    NonManifoldVertex {
        /// One of the faces.
        face: FaceId,
        /// How many fans meet there.
        fans: usize,
    },
    /// A component that cannot be oriented, and the options ask to refuse those.
    #[error("the component of {face} cannot be oriented; use the policy `Cut` to open a seam")]
    NonOrientable {
        /// One of the faces at the conflict.
        face: FaceId,
    },
    /// The build was cancelled.
    #[error("building the surface was cancelled")]
    Cancelled,
}
