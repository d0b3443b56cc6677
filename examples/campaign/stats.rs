//! Shares, medians and the like.

/// Times in milliseconds, sorted.
#[derive(Clone, Debug, Default)]
pub(crate) struct Times(Vec<f64>);

impl Times {
    pub(crate) fn new(times: impl IntoIterator<Item = f64>) -> Self {
        let mut times: Vec<f64> = times.into_iter().collect();
        times.sort_by(f64::total_cmp);
        Self(times)
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The smallest time that at least this share of all does not exceed; none of nothing.
    pub(crate) fn quantile(&self, share: f64) -> Option<f64> {
        let rank = (share * self.0.len() as f64).ceil() as usize;
        self.0.get(rank.saturating_sub(1)).copied()
    }

    /// The middle one, or the mean of the two middle ones.
    pub(crate) fn median(&self) -> Option<f64> {
        let n = self.0.len();
        let (a, b) = (self.0.get(n.saturating_sub(1) / 2)?, self.0.get(n / 2)?);
        Some((a + b) / 2.0)
    }

    /// Per cent of all that are below a bound.
    pub(crate) fn percent_below(&self, bound: f64) -> f64 {
        100.0 * self.0.partition_point(|t| *t < bound) as f64 / self.0.len().max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_a_hundred() {
        let times = Times::new((1..=100).rev().map(f64::from));
        assert_eq!(times.median(), Some(50.5));
        assert_eq!([0.9, 0.99, 1.0].map(|q| times.quantile(q)), [Some(90.0), Some(99.0), Some(100.0)]);
        assert_eq!(times.percent_below(26.0), 25.0);
        let none = Times::new([]);
        assert_eq!((none.median(), none.quantile(0.5), none.percent_below(1.0)), (None, None, 0.0));
        assert_eq!(Times::new([3.0]).median(), Some(3.0));
    }
}
