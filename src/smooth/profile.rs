//! How much a line turns, as a function of length along it: what is wished for it, on whatever strip.

use super::{layout::Layout, nodes::Node, strip::Strip};

/// The turn up to a share of the length. What a new strip turns by in all is what the old one did.
#[derive(Debug, Default)]
pub(crate) struct Profile {
    /// Shares of the length, growing, and the turn up to there.
    shares: Vec<f64>,
    sums: Vec<f64>,
    closed: bool,
    densities: Vec<f64>,
    widths: Vec<f64>,
    turns: Vec<f64>,
}

impl Profile {
    /// What a line turns by, its density spread to the neighbours `passes` times, times `scale`.
    ///
    /// Turns are integrals, which depend on how fine the mesh is; what is averaged are densities, turn by length, with
    /// weights ¼, ½, ¼ where crossings are evenly apart. What leaves one crossing arrives at its neighbour, so that the sum
    /// stays.
    ///
    /// Source: Lawonn et al. 2014; Pawellek, code 4.12, which averages the turns.
    pub(crate) fn measure(&mut self, strip: &Strip, layout: &Layout, nodes: &[Node], passes: u32, scale: f64) {
        let n = strip.len();
        self.closed = strip.closed;
        self.turns.clear();
        self.turns.resize(n, 0.0);
        for node in nodes {
            self.turns[(node.first + node.last) / 2] += node.turn;
        }
        self.widths.clear();
        let length = |j: usize| layout.stretch(j, &strip.at).length();
        self.widths.extend((0..n).map(|i| (0.5 * (length(i) + length(layout.after(i)))).max(f64::MIN_POSITIVE)));
        let pairs = if strip.closed { n } else { n.saturating_sub(1) };
        for _ in 0..passes {
            self.densities.clear();
            self.densities.extend(self.turns.iter().zip(&self.widths).map(|(turn, width)| turn / width));
            for i in 0..pairs {
                let j = if i + 1 == n { 0 } else { i + 1 };
                let flow = 0.25 * self.widths[i].min(self.widths[j]) * (self.densities[j] - self.densities[i]);
                self.turns[i] += flow;
                self.turns[j] -= flow;
            }
        }
        self.shares.clear();
        self.sums.clear();
        // A closed line's first share lies half way back to its last crossing.
        let begin = if strip.closed && n > 0 { 0.5 * (strip.along[n - 1] - 1.0) } else { 0.0 };
        self.shares.push(begin);
        self.sums.push(0.0);
        let mut sum = 0.0;
        for i in 0..n {
            sum += scale * self.turns[i];
            self.shares.push(if i + 1 < n { 0.5 * (strip.along[i] + strip.along[i + 1]) } else { begin + 1.0 });
            self.sums.push(sum);
        }
    }

    /// The turn up to a share of the length; of a closed line round after round.
    fn up_to(&self, share: f64) -> f64 {
        let [Some(begin), Some(whole)] = [self.shares.first(), self.sums.last()] else { return 0.0 };
        let rounds = if self.closed { (share - begin).floor() } else { 0.0 };
        let share = share - rounds;
        let k = self.shares.partition_point(|s| *s <= share).clamp(1, self.shares.len() - 1);
        let [from, to] = [self.shares[k - 1], self.shares[k]];
        let part = if to > from { ((share - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        rounds * whole + self.sums[k - 1] + part * (self.sums[k] - self.sums[k - 1])
    }

    /// What each crossing of a strip is to turn by: together as much as the line that was measured.
    pub(crate) fn wished(&self, strip: &Strip, out: &mut Vec<f64>) {
        out.clear();
        let n = strip.len();
        if self.shares.len() < 2 || n == 0 {
            out.resize(n, 0.0);
            return;
        }
        let whole = self.sums.last().copied().unwrap_or(0.0);
        for i in 0..n {
            let here = strip.along[i];
            // Shares of a closed line begin anew somewhere.
            let wrap = |there: f64, by: f64| if strip.closed && (there - here) * by < 0.0 { there + by } else { there };
            let before = wrap(strip.along[(i + n - 1) % n], -1.0);
            let after = wrap(strip.along[(i + 1) % n], 1.0);
            let from = if i > 0 || strip.closed { self.up_to(0.5 * (before + here)) } else { 0.0 };
            let to = if i + 1 < n || strip.closed { self.up_to(0.5 * (after + here)) } else { whole };
            out.push(to - from);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A made-up profile, for its sums.
    fn profile(closed: bool, along: &[f64]) -> Profile {
        let n = along.len();
        let begin = if closed { 0.5 * (along[n - 1] - 1.0) } else { 0.0 };
        let mut profile = Profile { closed, ..Profile::default() };
        (profile.shares, profile.sums) = (vec![begin], vec![0.0]);
        for i in 0..n {
            profile.shares.push(if i + 1 < n { 0.5 * (along[i] + along[i + 1]) } else { begin + 1.0 });
            profile.sums.push(profile.sums[i] + 0.1 * (i + 1) as f64);
        }
        profile
    }

    #[test]
    fn the_same_line_is_to_turn_as_it_did_and_others_by_as_much_in_all() {
        for closed in [false, true] {
            let along = if closed { [0.0, 0.2, 0.3, 0.7, 0.9] } else { [0.1, 0.2, 0.3, 0.7, 0.9] };
            let profile = profile(closed, &along);
            let strip = |along: Vec<f64>| Strip {
                closed,
                sides: vec![crate::surface::HalfEdge::NONE; along.len()],
                along,
                ..Strip::default()
            };
            let mut wished = Vec::new();
            profile.wished(&strip(along.to_vec()), &mut wished);
            assert!(wished.iter().enumerate().all(|(i, w)| (w - 0.1 * (i + 1) as f64).abs() < 1e-12), "{wished:?}");
            for other in [vec![0.5, 0.55, 0.8, 0.85], vec![0.01, 0.02, 0.4, 0.5, 0.6, 0.95]] {
                profile.wished(&strip(other.clone()), &mut wished);
                assert!((wished.iter().sum::<f64>() - 1.5).abs() < 1e-12, "{closed} {wished:?}");
                if closed {
                    let mut turned = other.clone();
                    turned.rotate_left(2);
                    profile.wished(&strip(turned), &mut wished);
                    assert!((wished.iter().sum::<f64>() - 1.5).abs() < 1e-12, "{wished:?}");
                }
            }
        }
    }
}
