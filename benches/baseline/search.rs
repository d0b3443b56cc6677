//! The strip of faces between two faces: a label-correcting search with small-label-first and large-label-last.

use std::collections::VecDeque;

use super::mesh::{Mesh, NONE};

/// What is known of a face that was reached.
#[derive(Clone, Copy, Debug)]
struct Label {
    /// Distance from the source along centres.
    distance: f32,
    /// The distance and a straight line from the centre to the target's.
    weight: f32,
    parent: u32,
    queued: bool,
}

const UNKNOWN: Label = Label { distance: f32::INFINITY, weight: f32::INFINITY, parent: NONE, queued: false };

pub(super) struct Search {
    labels: Vec<Label>,
    /// Faces whose labels are to be cleaned after the query.
    visited: Vec<u32>,
    queue: VecDeque<u32>,
}

impl Search {
    pub(super) fn new(faces: usize) -> Self {
        Self { labels: vec![UNKNOWN; faces], visited: Vec::new(), queue: VecDeque::new() }
    }

    /// Writes the faces from one to another; false if there is no way.
    pub(super) fn strip(&mut self, mesh: &Mesh, from: u32, to: u32, strip: &mut Vec<u32>) -> bool {
        strip.clear();
        strip.push(from);
        if from == to {
            return true;
        }
        // From the end to the start, so that parents lead the right way.
        let found = self.reach(mesh, to, from);
        if found {
            let mut face = from;
            while face != to {
                face = self.labels[face as usize].parent;
                strip.push(face);
            }
        }
        for face in self.visited.drain(..) {
            self.labels[face as usize] = UNKNOWN;
        }
        self.queue.clear();
        found
    }

    /// Labels faces until the target is touched for the first time.
    fn reach(&mut self, mesh: &Mesh, source: u32, target: u32) -> bool {
        let goal = mesh.nodes[target as usize].centre;
        let first = mesh.nodes[source as usize].centre.distance(goal);
        self.labels[source as usize] = Label { distance: 0.0, weight: first, parent: NONE, queued: true };
        self.visited.push(source);
        self.queue.push_back(source);
        let mut queued_weight = f64::from(first);

        while let Some(face) = self.pop(&mut queued_weight) {
            let node = &mesh.nodes[face as usize];
            let known = self.labels[face as usize].distance;
            for neighbour in node.neighbours {
                if neighbour == NONE {
                    continue;
                }
                let centre = mesh.nodes[neighbour as usize].centre;
                let distance = known + node.centre.distance(centre);
                let label = &mut self.labels[neighbour as usize];
                if distance >= label.distance {
                    continue;
                }
                if label.parent == NONE && neighbour != source {
                    self.visited.push(neighbour);
                }
                let weight = distance + centre.distance(goal);
                let old = std::mem::replace(label, Label { distance, weight, parent: face, queued: true });
                if neighbour == target {
                    return true;
                }
                if old.queued {
                    queued_weight += f64::from(weight) - f64::from(old.weight);
                    continue;
                }
                queued_weight += f64::from(weight);
                match self.queue.front() {
                    // Small label first.
                    Some(&front) if weight < self.labels[front as usize].weight => self.queue.push_front(neighbour),
                    _ => self.queue.push_back(neighbour),
                }
            }
        }
        false
    }

    /// Takes the next face: large label last, so those above the mean of the queue are put off.
    fn pop(&mut self, queued_weight: &mut f64) -> Option<u32> {
        let mean = *queued_weight / self.queue.len() as f64;
        for _ in 0..self.queue.len() {
            let front = *self.queue.front()?;
            if f64::from(self.labels[front as usize].weight) <= mean {
                break;
            }
            self.queue.rotate_left(1);
        }
        let face = self.queue.pop_front()?;
        let label = &mut self.labels[face as usize];
        label.queued = false;
        *queued_weight -= f64::from(label.weight);
        Some(face)
    }
}
