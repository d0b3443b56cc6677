//! Cutting ranges of faces into the nodes of a tree.

use super::{Bounds, Child, LEAF, NODE, Node};
use crate::surface::{
    BuildProgress, SurfaceError,
    parallel::{self, PIECE},
};

/// The nodes of the tree over faces with these boxes, at most `levels` deep: parents before their children, the root first.
///
/// # Errors
/// [`SurfaceError::Cancelled`].
pub(super) fn nodes(bounds: Vec<Bounds>, levels: u32, progress: &BuildProgress) -> Result<Vec<Node>, SurfaceError> {
    let mut areas_right = vec![0.0; bounds.len()];
    let part = Faces { first: 0, bounds: &bounds, areas_right: &mut areas_right }.part(levels, progress)?;
    // Before the nodes are copied: this is where a surface's build takes the most memory.
    drop((bounds, areas_right));
    let mut nodes = Vec::with_capacity(part.count());
    part.append_to(&mut nodes);
    Ok(nodes)
}

/// A range of faces.
struct Faces<'a> {
    first: u32,
    bounds: &'a [Bounds],
    /// For every cut, the area of the box on its right.
    areas_right: &'a mut [f32],
}

/// A part of the tree.
enum Part {
    Leaf(Child),
    /// Nodes that are counted from the first of them.
    Nodes(Vec<Node>),
    /// A node above two parts.
    Cut(Box<[Part; 2]>),
}

impl Part {
    fn count(&self) -> usize {
        match self {
            Self::Leaf(_) => 0,
            Self::Nodes(nodes) => nodes.len(),
            Self::Cut(parts) => 1 + parts[0].count() + parts[1].count(),
        }
    }

    /// Puts the part's nodes behind others, and returns the part as a child.
    fn append_to(self, nodes: &mut Vec<Node>) -> Child {
        let first = nodes.len() as u32;
        match self {
            Self::Leaf(leaf) => return leaf,
            Self::Nodes(part) => nodes.extend(part.into_iter().map(|node| node.moved(first))),
            Self::Cut(parts) => {
                nodes.push(Node::EMPTY);
                nodes[first as usize] = Node(parts.map(|part| part.append_to(nodes)));
            }
        }
        nodes[first as usize].as_child(first)
    }
}

impl Node {
    const EMPTY: Self = Self([Child { bounds: Bounds::EMPTY, first: 0, count: 0 }; 2]);

    fn as_child(&self, at: u32) -> Child {
        Child { bounds: self.0[0].bounds.union(self.0[1].bounds), first: at, count: NODE }
    }

    /// The node, where all nodes stand further back.
    fn moved(self, by: u32) -> Self {
        Self(self.0.map(|child| if child.count == NODE { Child { first: child.first + by, ..child } } else { child }))
    }
}

impl Faces<'_> {
    /// The subtree of these faces, at most `levels` nodes deep.
    fn part(mut self, levels: u32, progress: &BuildProgress) -> Result<Part, SurfaceError> {
        progress.check()?;
        if self.bounds.len() <= PIECE {
            let mut nodes = Vec::with_capacity(self.bounds.len() / 2);
            self.push_node(levels, &mut nodes);
            nodes.shrink_to_fit();
            return Ok(Part::Nodes(nodes));
        }
        let below = |faces: Faces| {
            if faces.is_leaf() { Ok(Part::Leaf(faces.leaf())) } else { faces.part(levels - 1, progress) }
        };
        let [left, right] = self.halves(levels);
        let (left, right) = parallel::join(|| below(left), || below(right));
        Ok(Part::Cut(Box::new([left?, right?])))
    }

    /// Makes the node of these faces, with its subtree behind it.
    fn push_node(&mut self, levels: u32, nodes: &mut Vec<Node>) -> Child {
        let at = nodes.len();
        nodes.push(Node::EMPTY);
        let children = self
            .halves(levels)
            .map(|mut half| if half.is_leaf() { half.leaf() } else { half.push_node(levels - 1, nodes) });
        nodes[at] = Node(children);
        nodes[at].as_child(at as u32)
    }

    fn is_leaf(&self) -> bool {
        self.bounds.len() <= LEAF
    }

    fn leaf(&self) -> Child {
        let bounds = self.bounds.iter().copied().fold(Bounds::EMPTY, Bounds::union);
        Child { bounds, first: self.first, count: self.bounds.len() as u32 }
    }

    fn halves(&mut self, levels: u32) -> [Faces<'_>; 2] {
        let cut = self.cut(levels);
        let (left, right) = self.bounds.split_at(cut);
        let (areas_left, areas_right) = self.areas_right.split_at_mut(cut);
        [
            Faces { first: self.first, bounds: left, areas_right: areas_left },
            Faces { first: self.first + cut as u32, bounds: right, areas_right },
        ]
    }

    /// Where to cut: least sum of area · faces of the two boxes, or the middle if the levels would not suffice.
    fn cut(&mut self, levels: u32) -> usize {
        let Self { bounds, areas_right, .. } = self;
        let half = bounds.len() / 2;
        // Halving needs this many levels below; a heuristic cut may take all the faces but one along.
        let needed = bounds.len().div_ceil(LEAF).next_power_of_two().ilog2();
        if needed >= levels || bounds.len() <= 2 {
            return half;
        }
        let mut right = Bounds::EMPTY;
        for (area, face) in areas_right.iter_mut().zip(*bounds).rev() {
            right = right.union(*face);
            *area = right.area();
        }
        let (mut best, mut least) = (half, f32::INFINITY);
        let mut left = bounds[0];
        for cut in 1..bounds.len() {
            let cost = left.area() * cut as f32 + areas_right[cut] * (bounds.len() - cut) as f32;
            // Where all boxes are alike, the middle: a chain would be as cheap by this count.
            if cost < least || (cost == least && cut.abs_diff(half) < best.abs_diff(half)) {
                (best, least) = (cut, cost);
            }
            left = left.union(bounds[cut]);
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::super::{MAX_DEPTH, tests::Random};
    use super::*;

    fn depth(nodes: &[Node], node: u32) -> usize {
        let below = nodes[node as usize].0.map(|child| if child.count == NODE { depth(nodes, child.first) } else { 0 });
        1 + below[0].max(below[1])
    }

    #[test]
    fn depth_is_bounded_where_areas_ask_for_a_chain() {
        // Every box dwarfs all before it: the heuristic cuts off one at a time.
        let boxes = |faces: i32, growth: f32| -> Vec<Bounds> {
            (0..faces).map(|face| Bounds { min: Vec3::ZERO, max: Vec3::splat(growth.powi(face)) }).collect()
        };
        let split = |bounds: Vec<Bounds>, levels: u32| {
            let faces = bounds.len();
            let nodes = nodes(bounds, levels, &BuildProgress::default()).unwrap();
            let leaves = nodes.iter().flat_map(|node| node.0).filter(|child| child.count != NODE);
            let mut found: Vec<u32> = leaves.flat_map(|leaf| leaf.faces()).collect();
            found.sort_unstable();
            assert!(found.into_iter().eq(0..faces as u32));
            depth(&nodes, 0)
        };
        assert_eq!(split(boxes(20, 8.0), 64), 16);
        for levels in 3..=16 {
            assert!(split(boxes(20, 8.0), levels) <= levels as usize);
        }
        // Equal boxes leave no cut better than another.
        assert_eq!(split(boxes(1024, 1.0), 64), 8);
    }

    #[test]
    fn parts_are_put_together_as_if_never_parted() {
        let mut random = Random(21);
        let bounds: Vec<Bounds> = (0..5 * PIECE)
            .map(|_| {
                let p = random.place().as_vec3();
                Bounds { min: p, max: p + Vec3::splat(0.1) }
            })
            .collect();
        let parted = nodes(bounds.clone(), MAX_DEPTH as u32, &BuildProgress::default()).unwrap();
        let mut whole = Vec::new();
        let mut areas_right = vec![0.0; bounds.len()];
        let mut faces = Faces { first: 0, bounds: &bounds, areas_right: &mut areas_right };
        faces.push_node(MAX_DEPTH as u32, &mut whole);
        assert_eq!(format!("{parted:?}"), format!("{whole:?}"));
    }
}
