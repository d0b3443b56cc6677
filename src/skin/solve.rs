//! Regular poses in double precision, and what they need of a handle.

use glam::{DAffine3, DMat3, DVec3};

use super::bound::read;
use super::system::{Link, System};
use super::turn::orthogonal_factor;
use super::{BoundChain, SkinError};

/// Memory for solving chains; can be used for one after the other.
#[derive(Clone, Debug, Default)]
pub struct SolveWorkspace {
    pub(crate) system: System,
    pub(crate) points: Vec<f64>,
    pub(crate) sides: Vec<f64>,
    pub(crate) loose: Vec<[DVec3; 4]>,
    /// How the anchors of a chain in space are turned, where that could be told.
    pub(crate) turns: Vec<DMat3>,
    pub(crate) even: Vec<f64>,
    pub(crate) odd: Vec<f64>,
    pub(crate) best: Vec<f64>,
}

impl BoundChain {
    /// The control points nearest to the skinned curve that keep the joins, in double precision; `transforms` has one for each handle.
    ///
    /// # Errors
    /// [`SkinError::PoseLength`], [`SkinError::PoseNotFinite`], [`SkinError::Singular`] if 64 bits are not enough.
    pub fn solve(
        &self,
        transforms: &[DAffine3],
        workspace: &mut SolveWorkspace,
        out: &mut Vec<DVec3>,
    ) -> Result<(), SkinError> {
        self.check(transforms)?;
        workspace.turns.clear();
        self.solve_regular(transforms, workspace)?;
        self.write(&workspace.points, out);
        Ok(())
    }

    /// The segments nearest to the skinned curve that need not meet, one after the other.
    ///
    /// # Errors
    /// [`SkinError::PoseLength`], [`SkinError::PoseNotFinite`].
    pub fn solve_loose(&self, transforms: &[DAffine3]) -> Result<Vec<[DVec3; 4]>, SkinError> {
        self.check(transforms)?;
        let mut out = Vec::new();
        self.loose(transforms, &mut out);
        Ok(out)
    }

    /// Solves into the workspace's points. Turns that cannot be told are those of the workspace.
    pub(crate) fn solve_regular(
        &self,
        transforms: &[DAffine3],
        workspace: &mut SolveWorkspace,
    ) -> Result<(), SkinError> {
        if self.turns_along() {
            self.turn(transforms, &mut workspace.turns);
        }
        let SolveWorkspace { system, points, turns, .. } = workspace;
        let coupled = self.coupled();
        let link = |anchor| self.posed_link(anchor, turns);
        system.build(&self.chain, &self.grams, coupled, link).map_err(|_| SkinError::Singular { chain: 0 })?;
        self.sides(transforms, points);
        system.solve(&self.chain, &self.grams, points, self.dimension() / coupled, Some(0));
        Ok(())
    }

    /// What ties the handles of an anchor in a pose.
    pub(crate) fn posed_link(&self, anchor: usize, turns: &[DMat3]) -> Link {
        self.ties[anchor].map_or(Link::Free, |tie| Link::Tied(self.posed_turn(anchor, turns) * tie.ratio))
    }

    /// What takes the direction of the incoming handle to that of the outgoing one in a pose.
    pub(crate) fn posed_turn(&self, anchor: usize, turns: &[DMat3]) -> DMat3 {
        let Some(tie) = self.ties[anchor] else { return DMat3::IDENTITY };
        match turns.get(anchor).filter(|_| tie.turned && self.turns_along()) {
            Some(q) => *q * tie.turn * q.transpose(),
            None => tie.turn,
        }
    }

    /// How the handles turn each anchor that has an angle.
    pub(crate) fn turn(&self, transforms: &[DAffine3], turns: &mut Vec<DMat3>) {
        turns.resize(self.ties.len(), DMat3::IDENTITY);
        let weights = self.anchor_weights.chunks_exact(self.stride());
        for ((tie, weights), turn) in self.ties.iter().zip(weights).zip(turns) {
            if tie.is_some_and(|tie| tie.turned) {
                let moved = weights.iter().zip(&self.handles);
                let sum = moved.fold(DMat3::ZERO, |sum, (w, handle)| sum + transforms[*handle as usize].matrix3 * *w);
                *turn = orthogonal_factor(sum).unwrap_or(*turn);
            }
        }
    }

    pub(crate) fn write(&self, points: &[f64], out: &mut Vec<DVec3>) {
        out.clear();
        out.extend((0..self.chain.points().len()).map(|place| read(points, place, self.dimension())));
    }

    /// The control points as sums over handles: for each row of a control point (one, or two where the plane's coordinates hang together)
    /// the factors of each handle. Those of one row are x, y (z) and 1 of the handle's transform; of two rows, the parts of the transform
    /// that keep angles and that mirror them, and its shift (α, β and τ of T p = α p + β p̄ + τ). Columns of constants are not asked for.
    pub(crate) fn influences(&self, workspace: &mut SolveWorkspace) -> Result<Influences, SkinError> {
        let (d, coupled) = (self.dimension(), self.coupled());
        let of_handle = if coupled == 1 { d + 1 } else { 3 };
        let columns = of_handle * self.handles.len();
        let mut values = vec![0.0; self.chain.points().len() * coupled * columns];
        for (segment, moments) in self.moments.chunks_exact(self.stride()).enumerate() {
            for (k, place) in self.chain.places(segment).into_iter().enumerate() {
                for (handle, moment) in moments.iter().enumerate() {
                    let [x, y, z, one] = moment.map(|row| row[k]);
                    let mut add = |row: usize, what: &[f64]| {
                        let at = (place * coupled + row) * columns + handle * of_handle;
                        values[at..][..of_handle].iter_mut().zip(what).for_each(|(into, x)| *into += x);
                    };
                    match (coupled, d) {
                        (1, 2) => add(0, &[x, y, one]),
                        (1, _) => add(0, &[x, y, z, one]),
                        _ => {
                            add(0, &[x, x, one]);
                            add(1, &[y, -y, 0.0]);
                        }
                    }
                }
            }
        }
        let system = &mut workspace.system;
        system
            .build(&self.chain, &self.grams, coupled, |anchor| self.rest_link(anchor))
            .map_err(|_| SkinError::Singular { chain: 0 })?;
        system.solve(&self.chain, &self.grams, &mut values, columns, None);
        Ok(Influences { of_handle, columns, values })
    }
}

/// Control points as sums over handles.
pub(crate) struct Influences {
    pub(crate) of_handle: usize,
    pub(crate) columns: usize,
    pub(crate) values: Vec<f64>,
}
