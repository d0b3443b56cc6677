//! Chains that the same handles move in the same way, as one list of control points.

use glam::{DAffine3, DVec3};

use super::{BoundChain, SkinError, SolveWorkspace, spread};

/// What a handle's transform does to a control point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kernel {
    /// Factors of x, y and 1, the same for both coordinates.
    Plane,
    /// Complex factors of the part that keeps angles, the part that mirrors them, and the shift.
    Turned,
    /// Factors of x, y, z and 1, the same for all coordinates.
    Space,
}

impl Kernel {
    /// That of a chain; none if it has to be solved pose by pose.
    pub(super) fn of(bound: &BoundChain) -> Option<Self> {
        match (bound.dimension(), bound.coupled()) {
            (2, 1) => Some(Self::Plane),
            (2, _) => Some(Self::Turned),
            (_, 1) => Some(Self::Space),
            _ => None,
        }
    }

    /// Numbers for each handle and control point.
    fn rows(self) -> usize {
        match self {
            Self::Plane => 3,
            Self::Turned => 6,
            Self::Space => 4,
        }
    }
}

/// What a handle's transform does beyond staying, about the skin's origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors {
    /// Rows of the linear part less the identity.
    linear: [[f32; 3]; 3],
    shift: [f32; 3],
    /// The same for what lies in the plane z = 0.
    plane_shift: [f32; 2],
    /// Of the plane's part that keeps angles, less one.
    keeps: [f32; 2],
    /// Of the plane's part that mirrors.
    mirrors: [f32; 2],
}

impl Factors {
    /// Whether single precision holds all of them.
    pub(super) fn is_finite(&self) -> bool {
        let numbers = self.linear.as_flattened().iter().chain(&self.shift).chain(&self.plane_shift);
        numbers.chain(&self.keeps).chain(&self.mirrors).all(|x| x.is_finite())
    }

    pub(super) fn new(transform: &DAffine3, origin: DVec3) -> Self {
        let m = transform.matrix3;
        let about = |origin: DVec3| (m * origin + transform.translation - origin).as_vec3();
        let in_plane = about(origin.truncate().extend(0.0));
        let row = |k: usize| {
            let row = m.row(k) - DVec3::AXES[k];
            row.as_vec3().to_array()
        };
        let (a, b, c, d) = (m.x_axis.x, m.y_axis.x, m.x_axis.y, m.y_axis.y);
        Self {
            linear: [row(0), row(1), row(2)],
            shift: about(origin).to_array(),
            plane_shift: in_plane.truncate().to_array(),
            keeps: [(0.5 * (a - 1.0 + d - 1.0)) as f32, (0.5 * (c - b)) as f32],
            mirrors: [(0.5 * (a - d)) as f32, (0.5 * (c + b)) as f32],
        }
    }
}

/// Control points of chains that the same handles move in the same way.
#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) kernel: Kernel,
    pub(super) handles: Vec<u32>,
    count: usize,
    /// Of the first handle: all first numbers, all second ones, …; then of the second handle.
    values: Vec<f32>,
}

impl Block {
    pub(super) fn new(kernel: Kernel, handles: &[u32]) -> Self {
        Self { kernel, handles: handles.to_vec(), count: 0, values: Vec::new() }
    }

    /// Takes in chains, which have so many control points together; `numbers` are their places in the skin.
    pub(super) fn fill(
        &mut self,
        chains: &[&BoundChain],
        numbers: &[usize],
        count: usize,
        origin: DVec3,
    ) -> Result<(), SkinError> {
        self.count = count;
        let rows = self.kernel.rows();
        self.values = vec![0.0; self.handles.len() * rows * count];
        let all = spread::map(chains, SolveWorkspace::default, |workspace, i, bound| {
            bound.influences(workspace).map_err(|_| SkinError::Singular { chain: numbers[i] })
        });
        let mut first = 0;
        for (bound, influences) in chains.iter().zip(all) {
            let influences = influences?;
            let coupled = bound.coupled();
            let points = influences.values.chunks_exact((influences.columns * coupled).max(1));
            for (point, of_point) in points.enumerate() {
                for handle in 0..self.handles.len() {
                    let at = handle * influences.of_handle;
                    let of_row = |row: usize| &of_point[row * influences.columns + at..][..influences.of_handle];
                    let put = |k: usize, value: f64, values: &mut Vec<f32>| {
                        values[(handle * rows + k) * count + first + point] = value as f32;
                    };
                    match self.kernel {
                        Kernel::Plane | Kernel::Space => {
                            let one = of_row(0)[rows - 1];
                            for (k, value) in of_row(0).iter().enumerate() {
                                let about = if k + 1 < rows { origin[k] * one } else { 0.0 };
                                put(k, value - about, &mut self.values);
                            }
                        }
                        Kernel::Turned => {
                            // About the origin: less its complex product with the shift's factor, for the mirrored part less that
                            // of its conjugate.
                            let [re, im] = [0, 1].map(of_row);
                            let (tx, ty, ox, oy) = (re[2], im[2], origin.x, origin.y);
                            let numbers = [
                                re[0] - (ox * tx - oy * ty),
                                im[0] - (ox * ty + oy * tx),
                                re[1] - (ox * tx + oy * ty),
                                im[1] - (ox * ty - oy * tx),
                                tx,
                                ty,
                            ];
                            for (k, value) in numbers.into_iter().enumerate() {
                                put(k, value, &mut self.values);
                            }
                        }
                    }
                }
            }
            first += bound.chain().points().len();
        }
        match self.values.iter().position(|value| !value.is_finite()) {
            Some(place) => Err(SkinError::TooLarge { chain: owner(chains, numbers, place % count.max(1)) }),
            None => Ok(()),
        }
    }

    /// Adds what all handles do to the control points from `from` on.
    pub(super) fn pose(&self, from: usize, factors: &[Factors], x: &mut [f32], y: &mut [f32], z: &mut [f32]) {
        let (rows, len) = (self.kernel.rows(), x.len());
        for (number, handle) in self.handles.iter().enumerate() {
            let f = &factors[*handle as usize];
            let row = |k: usize| &self.values[(number * rows + k) * self.count + from..][..len];
            match self.kernel {
                Kernel::Plane => {
                    let inputs = [row(0), row(1), row(2)];
                    add_three(x, inputs, [f.linear[0][0], f.linear[0][1], f.plane_shift[0]]);
                    add_three(y, inputs, [f.linear[1][0], f.linear[1][1], f.plane_shift[1]]);
                }
                Kernel::Turned => {
                    let ([k, l], [m, n], [s, t]) = (f.keeps, f.mirrors, f.plane_shift);
                    let (keeps, mirrors, shifts) = ([row(0), row(1)], [row(2), row(3)], [row(4), row(5)]);
                    add_three(x, [keeps[0], mirrors[0], shifts[0]], [k, m, s]);
                    add_three(x, [keeps[1], mirrors[1], shifts[1]], [-l, -n, -t]);
                    add_three(y, [keeps[0], mirrors[0], shifts[0]], [l, n, t]);
                    add_three(y, [keeps[1], mirrors[1], shifts[1]], [k, m, s]);
                }
                Kernel::Space => {
                    let inputs = [row(0), row(1), row(2)];
                    for (axis, out) in [&mut *x, &mut *y, &mut *z].into_iter().enumerate() {
                        add_three(out, inputs, f.linear[axis]);
                        add_one(out, row(3), f.shift[axis]);
                    }
                }
            }
        }
    }
}

/// Which of some chains, one after the other, has a control point.
fn owner(chains: &[&BoundChain], numbers: &[usize], point: usize) -> usize {
    let ends = chains.iter().scan(0, |end, bound| {
        *end += bound.chain().points().len();
        Some(*end)
    });
    ends.zip(numbers).find(|(end, _)| point < *end).map_or(0, |(_, number)| *number)
}

#[inline]
fn add_three(out: &mut [f32], [a, b, c]: [&[f32]; 3], [p, q, r]: [f32; 3]) {
    for (((out, a), b), c) in out.iter_mut().zip(a).zip(b).zip(c) {
        *out += p * a + q * b + r * c;
    }
}

#[inline]
fn add_one(out: &mut [f32], a: &[f32], p: f32) {
    out.iter_mut().zip(a).for_each(|(out, a)| *out += p * a);
}
