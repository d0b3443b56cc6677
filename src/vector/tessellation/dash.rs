//! Dashes: the parts of a path that are drawn.

/// A part of a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Part {
    /// The segment, by its place in the path.
    pub(super) segment: u32,
    pub(super) from: f32,
    pub(super) to: f32,
}

/// Dashes that a path has at most; a finer pattern is drawn as an unbroken line.
const MOST: f64 = 4096.0;

/// Cuts a path into dashes; none if the pattern draws an unbroken line. Of each segment it wants the lengths up to parameters in equal steps.
/// Dashes without length are left out.
pub(super) fn dashes(lengths: &[Vec<f64>], pattern: &[f64], offset: f64) -> Option<Vec<Vec<Part>>> {
    let period: f64 = pattern.iter().sum::<f64>() * if pattern.len() % 2 == 1 { 2.0 } else { 1.0 };
    let total: f64 = lengths.iter().filter_map(|of| of.last()).sum();
    let fine = pattern.iter().all(|length| *length >= 0.0) && period > 0.0;
    let finite = period.is_finite() && total.is_finite() && offset.is_finite();
    if !fine || !finite || total / period * pattern.len() as f64 > MOST {
        return None;
    }
    let wanted = |number: usize| pattern[number % pattern.len()];
    let (mut number, mut left) = (0, offset.rem_euclid(period));
    while left >= wanted(number) {
        left -= wanted(number);
        number += 1;
    }
    let mut left = wanted(number) - left;
    let mut all: Vec<Vec<Part>> = Vec::new();
    if number % 2 == 0 {
        all.push(Vec::new());
    }
    for (segment, along) in (0..).zip(lengths) {
        let length = along.last().copied().unwrap_or(0.0);
        let (mut at, mut from) = (0.0, 0.0_f32);
        loop {
            let ends_here = at + left <= length;
            let to = if ends_here { parameter(along, at + left) } else { 1.0 };
            if number % 2 == 0
                && let Some(dash) = all.last_mut()
                && to > from
            {
                dash.push(Part { segment, from, to });
            }
            if !ends_here {
                left -= length - at;
                break;
            }
            (at, from) = (at + left, to);
            number += 1;
            left = wanted(number);
            if number % 2 == 0 {
                all.push(Vec::new());
            }
            // Two lengths of zero in a row would go on for ever; with a period that is not zero this ends.
        }
    }
    all.retain(|dash| !dash.is_empty());
    Some(all)
}

/// The parameter at which a segment has some length, between the steps at which lengths are known.
fn parameter(along: &[f64], length: f64) -> f32 {
    let steps = along.len().saturating_sub(1).max(1) as f64;
    let next = along.partition_point(|known| *known <= length).max(1);
    let (Some(before), Some(after)) = (along.get(next - 1), along.get(next)) else { return 1.0 };
    (((next - 1) as f64 + (length - before) / (after - before)) / steps).clamp(0.0, 1.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two straight segments, each of length 2.
    fn two() -> Vec<Vec<f64>> {
        vec![(0..=4).map(|i| f64::from(i) / 2.0).collect(); 2]
    }

    fn drawn(pattern: &[f64], offset: f64) -> Vec<[f32; 2]> {
        let dashes = dashes(&two(), pattern, offset).unwrap();
        let place = |part: &Part, t: f32| 2.0 * (part.segment as f32 + t);
        dashes.iter().map(|d| [place(&d[0], d[0].from), place(d.last().unwrap(), d.last().unwrap().to)]).collect()
    }

    #[test]
    fn dashes_lie_where_the_pattern_says() {
        assert_eq!(drawn(&[1.0, 0.5], 0.0), [[0.0, 1.0], [1.5, 2.5], [3.0, 4.0]]);
        assert_eq!(drawn(&[1.0, 0.5], 1.25), [[0.25, 1.25], [1.75, 2.75], [3.25, 4.0]]);
        assert_eq!(drawn(&[1.0, 0.5], -0.5), drawn(&[1.0, 0.5], 1.0));
        assert_eq!(drawn(&[1.0], 0.0), [[0.0, 1.0], [2.0, 3.0]]);
        assert_eq!(drawn(&[3.0, 0.0], 0.0), [[0.0, 3.0], [3.0, 4.0]]);
    }

    #[test]
    fn patterns_that_make_no_sense_draw_a_line() {
        for pattern in [&[][..], &[0.0], &[-1.0, 2.0], &[1e-6], &[f64::NAN], &[f64::INFINITY]] {
            assert!(dashes(&two(), pattern, 0.0).is_none_or(|dashes| dashes.len() <= 1), "{pattern:?}");
        }
        // Each length is finite, and their sum is not.
        assert_eq!(dashes(&two(), &[1e308, 1e308], -1.0), None);
    }
}
