//! Many chains bound to handles, posed by few operations a control point.

use std::collections::HashMap;
use std::ops::Range;

use glam::{DAffine2, DAffine3, DVec3, Vec3};

use super::block::{Block, Factors, Kernel};
use super::flexible::{FlexibleOptions, FlexibleOutcome};
use super::{BindOptions, BoundChain, Chain, SkinError, SolveWorkspace, WeightField, spread};

/// Control points of a pose, in single precision, and the memory to make the next one in.
///
/// Coordinates lie apart, chain after chain in an order of the skin's own: see [`BoundSkin::place_of`].
#[derive(Clone, Debug, Default)]
pub struct Posed {
    x: Vec<f32>,
    y: Vec<f32>,
    /// Zero for chains of the plane.
    z: Vec<f32>,
    factors: Vec<Factors>,
    /// One for each chain that is solved pose by pose.
    solved: Vec<Solved>,
    wide: Vec<DAffine3>,
}

/// A chain that is solved pose by pose.
#[derive(Clone, Debug, Default)]
struct Solved {
    workspace: SolveWorkspace,
    points: Vec<DVec3>,
    failed: bool,
}

impl Posed {
    /// The x coordinates of all control points.
    pub fn x(&self) -> &[f32] {
        &self.x
    }

    /// The y coordinates.
    pub fn y(&self) -> &[f32] {
        &self.y
    }

    /// The z coordinates; zero for chains of the plane.
    pub fn z(&self) -> &[f32] {
        &self.z
    }
}

/// What a flexible pose of many chains came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
pub struct FlexibleReport {
    /// Chains with a free ratio.
    pub chains: usize,
    /// Those of them that stopped because hardly anything changed.
    pub settled: usize,
    /// Most pairs of solves that a chain took.
    pub most_pairs: u32,
    /// Energy of the regular pose above that of loose segments.
    pub regular: f64,
    /// The same of the flexible pose.
    pub flexible: f64,
}

/// Chains bound to handles.
///
/// Binding does all that does not depend on the pose: a control point becomes a sum over handles. A pose is then three multiplications and
/// additions for each coordinate, handle and control point of a planar chain, six where it keeps an angle, four in space. Chains in
/// space that keep an angle are solved anew in each pose.
///
/// ```
/// use bevy_surface_splines::{skin::{Chain, HandleShape, JoinRules, Shepard, BoundSkin}, vector::VectorPath};
/// use glam::{DAffine2, DVec2};
///
/// let points = [(0.0, 0.0), (1.0, 1.0), (2.0, 1.0), (3.0, 0.0)].map(DVec2::from);
/// let path = VectorPath::from_points(points.to_vec(), false).unwrap();
/// let weights = Shepard::new(&[HandleShape::planar(points[0]), HandleShape::planar(points[3])])?;
/// let skin = BoundSkin::bind(vec![Chain::planar(&path, &JoinRules::default())], &weights, &Default::default())?;
/// let mut posed = skin.at_rest();
/// skin.pose_plane(&[DAffine2::IDENTITY, DAffine2::from_translation(DVec2::Y)], &mut posed)?;
/// let last = skin.points(&posed, 0).last().unwrap();
/// assert!((last.y - 1.0).abs() < 0.01);
/// # Ok::<(), bevy_surface_splines::skin::SkinError>(())
/// ```
#[derive(Clone, Debug)]
pub struct BoundSkin {
    handles: usize,
    chains: Vec<BoundChain>,
    /// Where the control points of each chain are.
    places: Vec<Range<usize>>,
    blocks: Vec<Block>,
    /// Pieces of blocks in the order of places.
    pieces: Vec<Piece>,
    /// Chains that are solved pose by pose; their points come last.
    solved: Vec<usize>,
    /// Transforms are taken about this place, so that no digits are lost far from the origin.
    origin: DVec3,
    rest: [Vec<f32>; 3],
}

/// Some control points of a block.
#[derive(Clone, Copy, Debug)]
struct Piece {
    block: usize,
    from: usize,
    len: usize,
}

/// Control points of a piece: what they need of a handle stays in the nearest memory.
const PIECE: usize = 1024;

impl BoundSkin {
    /// Binds chains to handles. With the feature `parallel` chains are spread over the caller's pool; the result is the same.
    ///
    /// # Errors
    /// [`SkinError::NoHandles`], [`SkinError::NoWeights`], [`SkinError::Singular`], [`SkinError::TooLarge`].
    pub fn bind(chains: Vec<Chain>, weights: &dyn WeightField, options: &BindOptions) -> Result<Self, SkinError> {
        let bound = spread::map(&chains, || (), |(), number, chain| BoundChain::new(chain, number, weights, options));
        Self::of_bound(bound.into_iter().collect::<Result<_, _>>()?, weights.handle_count())
    }

    /// Prepares chains that are bound already, to so many handles.
    ///
    /// # Errors
    /// [`SkinError::OtherHandles`], [`SkinError::Singular`], [`SkinError::TooLarge`].
    pub fn of_bound(chains: Vec<BoundChain>, handles: usize) -> Result<Self, SkinError> {
        if let Some(chain) = chains.iter().position(|bound| bound.handle_count != handles) {
            return Err(SkinError::OtherHandles { chain, found: chains[chain].handle_count, handles });
        }
        let points = || chains.iter().flat_map(|bound| bound.chain().points().iter().copied());
        let low = points().reduce(DVec3::min).unwrap_or_default();
        let high = points().reduce(DVec3::max).unwrap_or_default();
        let origin = 0.5 * (low + high);
        let mut blocks: Vec<Block> = Vec::new();
        let mut members: Vec<Vec<usize>> = Vec::new();
        let mut solved = Vec::new();
        let mut known: HashMap<(Kernel, &Vec<u32>), usize> = HashMap::new();
        for (number, bound) in chains.iter().enumerate() {
            let Some(kernel) = Kernel::of(bound) else {
                solved.push(number);
                continue;
            };
            let block = *known.entry((kernel, &bound.handles)).or_insert_with(|| {
                blocks.push(Block::new(kernel, &bound.handles));
                members.push(Vec::new());
                blocks.len() - 1
            });
            members[block].push(number);
        }
        let (mut places, mut next, mut pieces) = (vec![0..0; chains.len()], 0, Vec::new());
        for (number, (block, members)) in blocks.iter_mut().zip(&members).enumerate() {
            let first = next;
            for chain in members {
                let count = chains[*chain].chain().points().len();
                places[*chain] = next..next + count;
                next += count;
            }
            let all = (0..next - first).step_by(PIECE);
            pieces.extend(all.map(|from| Piece { block: number, from, len: PIECE.min(next - first - from) }));
            let bound: Vec<&BoundChain> = members.iter().map(|member| &chains[*member]).collect();
            block.fill(&bound, members, next - first, origin)?;
        }
        for chain in &solved {
            let count = chains[*chain].chain().points().len();
            places[*chain] = next..next + count;
            next += count;
        }
        let mut skin = Self { handles, places, blocks, pieces, solved, origin, rest: Default::default(), chains };
        skin.rest = skin.find_rest(next)?;
        Ok(skin)
    }

    /// Control points with all handles at rest: those of the chains, moved only by pins elsewhere.
    fn find_rest(&self, count: usize) -> Result<[Vec<f32>; 3], SkinError> {
        let mut rest = [vec![0.0; count], vec![0.0; count], vec![0.0; count]];
        let still = vec![DAffine3::IDENTITY; self.handles];
        let (mut workspace, mut moved) = Default::default();
        for (number, (bound, place)) in self.chains.iter().zip(&self.places).enumerate() {
            let is_pinned = bound.chain().joins().iter().any(|join| join.pinned.is_some());
            let points = if is_pinned {
                bound.solve(&still, &mut workspace, &mut moved).map_err(|_| SkinError::Singular { chain: number })?;
                &moved[..]
            } else {
                bound.chain().points()
            };
            if points.iter().any(|p| !p.as_vec3().is_finite()) {
                return Err(SkinError::TooLarge { chain: number });
            }
            for (axis, rest) in rest.iter_mut().enumerate() {
                rest[place.clone()].iter_mut().zip(points).for_each(|(out, p)| *out = p[axis] as f32);
            }
        }
        Ok(rest)
    }

    /// Number of handles.
    pub fn handle_count(&self) -> usize {
        self.handles
    }

    /// The chains.
    pub fn chains(&self) -> &[BoundChain] {
        &self.chains
    }

    /// Number of control points.
    pub fn point_count(&self) -> usize {
        self.rest[0].len()
    }

    /// Where the control points of a chain are among all; empty if there is no such chain.
    pub fn place_of(&self, chain: usize) -> Range<usize> {
        self.places.get(chain).cloned().unwrap_or_default()
    }

    /// The pose in which no handle has moved.
    pub fn at_rest(&self) -> Posed {
        let mut posed = Posed::default();
        self.fit(&mut posed);
        posed
    }

    /// The control points of a chain in a pose; none if there is no such chain.
    pub fn points<'a>(&self, posed: &'a Posed, chain: usize) -> impl ExactSizeIterator<Item = Vec3> + use<'a> {
        let place = self.place_of(chain);
        let place = if place.end <= posed.x.len() { place } else { 0..0 };
        place.map(|at| Vec3::new(posed.x[at], posed.y[at], posed.z[at]))
    }

    /// Poses all chains by transforms of the plane, one for each handle. Takes no memory once `posed` was used with this skin.
    ///
    /// # Errors
    /// As [`pose`](Self::pose).
    pub fn pose_plane(&self, transforms: &[DAffine2], posed: &mut Posed) -> Result<(), SkinError> {
        let mut wide = std::mem::take(&mut posed.wide);
        wide.clear();
        wide.extend(transforms.iter().map(in_space));
        let result = self.pose(&wide, posed);
        posed.wide = wide;
        result
    }

    /// Poses all chains by transforms in space, one for each handle; chains of the plane take what they say of x and y. Takes no memory once
    /// `posed` was used with this skin. With the feature `parallel` points are spread over the caller's pool; the result is the same to the bit.
    ///
    /// # Errors
    /// [`SkinError::PoseLength`], [`SkinError::PoseNotFinite`]; [`SkinError::Singular`] for a chain in space with angles: `posed` has it at
    /// its last place then.
    pub fn pose(&self, transforms: &[DAffine3], posed: &mut Posed) -> Result<(), SkinError> {
        self.check(transforms)?;
        self.fit(posed);
        let Posed { x, y, z, factors, solved, .. } = posed;
        factors.clear();
        factors.extend(transforms.iter().map(|transform| Factors::new(transform, self.origin)));
        if let Some(handle) = factors.iter().position(|factors| !factors.is_finite()) {
            return Err(SkinError::PoseNotFinite { handle });
        }
        self.pose_pieces(&self.pieces, 0, x, y, z, factors);
        self.solve_all(solved, 0, transforms);
        let mut result = Ok(());
        for (one, chain) in solved.iter().zip(&self.solved) {
            if one.failed {
                result = result.and(Err(SkinError::Singular { chain: *chain }));
                continue;
            }
            for (at, point) in self.places[*chain].clone().zip(&one.points) {
                (x[at], y[at], z[at]) = (point.x as f32, point.y as f32, point.z as f32);
            }
        }
        result
    }

    /// Poses all chains with the ratios of handle lengths free where joins allow it: slower, and nearer to the skinned curves.
    ///
    /// # Errors
    /// As [`pose`](Self::pose).
    pub fn pose_flexible(
        &self,
        transforms: &[DAffine3],
        options: &FlexibleOptions,
        posed: &mut Posed,
    ) -> Result<FlexibleReport, SkinError> {
        self.pose(transforms, posed)?;
        let solve = |workspace: &mut SolveWorkspace, number: usize, bound: &BoundChain| {
            let mut points = Vec::new();
            if !bound.is_flexible() {
                return Ok((FlexibleOutcome::default(), points));
            }
            let outcome = bound.solve_flexible(transforms, options, workspace, &mut points);
            outcome.map(|outcome| (outcome, points)).map_err(|_| SkinError::Singular { chain: number })
        };
        let all = spread::map(&self.chains, SolveWorkspace::default, solve);
        let mut report = FlexibleReport::default();
        for (one, place) in all.into_iter().zip(&self.places) {
            let (outcome, points) = one?;
            if points.is_empty() {
                continue;
            }
            for (at, point) in place.clone().zip(points) {
                (posed.x[at], posed.y[at], posed.z[at]) = (point.x as f32, point.y as f32, point.z as f32);
            }
            report.chains += 1;
            report.settled += usize::from(outcome.settled);
            report.most_pairs = report.most_pairs.max(outcome.pairs);
            report.regular += outcome.regular;
            report.flexible += outcome.flexible;
        }
        Ok(report)
    }

    fn check(&self, transforms: &[DAffine3]) -> Result<(), SkinError> {
        if transforms.len() != self.handles {
            return Err(SkinError::PoseLength { handles: self.handles, found: transforms.len() });
        }
        match transforms.iter().position(|transform| !transform.is_finite()) {
            Some(handle) => Err(SkinError::PoseNotFinite { handle }),
            None => Ok(()),
        }
    }

    /// Gives a pose the size of this skin.
    fn fit(&self, posed: &mut Posed) {
        if posed.x.len() != self.point_count() || posed.solved.len() != self.solved.len() {
            let [x, y, z] = self.rest.clone();
            let solved = vec![Solved::default(); self.solved.len()];
            *posed = Posed { x, y, z, solved, factors: Vec::with_capacity(self.handles), wide: Vec::new() };
        }
    }

    /// Poses pieces, whose points are from `first` on.
    fn pose_pieces(
        &self,
        pieces: &[Piece],
        first: usize,
        x: &mut [f32],
        y: &mut [f32],
        z: &mut [f32],
        factors: &[Factors],
    ) {
        if pieces.len() > 4 {
            let (before, behind) = pieces.split_at(pieces.len() / 2);
            let count = before.iter().map(|piece| piece.len).sum();
            let ((xa, xb), (ya, yb), (za, zb)) = (x.split_at_mut(count), y.split_at_mut(count), z.split_at_mut(count));
            spread::join(
                || self.pose_pieces(before, first, xa, ya, za, factors),
                || self.pose_pieces(behind, first + count, xb, yb, zb, factors),
            );
            return;
        }
        let mut at = 0;
        for piece in pieces {
            let range = at..at + piece.len;
            let (x, y, z) = (&mut x[range.clone()], &mut y[range.clone()], &mut z[range.clone()]);
            for (out, rest) in [&mut *x, &mut *y, &mut *z].into_iter().zip(&self.rest) {
                out.copy_from_slice(&rest[first + range.start..first + range.end]);
            }
            self.blocks[piece.block].pose(piece.from, factors, x, y, z);
            at += piece.len;
        }
    }

    /// Solves chains from the `first` of those that are solved pose by pose.
    fn solve_all(&self, solved: &mut [Solved], first: usize, transforms: &[DAffine3]) {
        if let [one] = solved {
            let bound = &self.chains[self.solved[first]];
            one.failed = bound.solve_regular(transforms, &mut one.workspace).is_err();
            if !one.failed {
                bound.write(&one.workspace.points, &mut one.points);
            }
        } else if !solved.is_empty() {
            let middle = solved.len() / 2;
            let (before, behind) = solved.split_at_mut(middle);
            spread::join(
                || self.solve_all(before, first, transforms),
                || self.solve_all(behind, first + middle, transforms),
            );
        }
    }
}

/// A transform of the plane as one of space, which leaves z.
pub fn in_space(transform: &DAffine2) -> DAffine3 {
    let m = transform.matrix2;
    DAffine3 {
        matrix3: glam::DMat3::from_cols(m.x_axis.extend(0.0), m.y_axis.extend(0.0), DVec3::Z),
        translation: transform.translation.extend(0.0),
    }
}
