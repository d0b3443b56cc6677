//! Quadratic programs with bounds: the least wᵀQw with 0 ≤ w ≤ 1 and some values fixed.
//!
//! First alternating directions of multipliers with one factor, which finds nearly all values that are at a bound. Then an active set: fix what is
//! at a bound, solve the rest exactly, bound what leaves, release what pulls inwards. It ends with the exact minimum (Jacobson et al. 2011 for
//! the program; Hintermüller, Ito and Kunisch 2003 for the active set).

use super::WeightsError;
use super::sparse::{Pattern, Symmetric};

/// What a program came to.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    pub(super) values: Vec<f64>,
    /// Rounds of the active set.
    pub(super) rounds: u32,
    /// Whether they ended by themselves.
    pub(super) settled: bool,
}

/// Rounds of the active set at most; five to ten are usual.
const ROUNDS: u32 = 80;
/// By how much a value may leave its bounds before it is held there.
const LEAVES: f64 = 1e-7;
/// By how much a multiplier may pull inwards, as a share of the mean diagonal; without, rounding makes it cycle.
const PULLS: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Free,
    Fixed(f64),
    Low,
    High,
}

impl State {
    fn value(self) -> Option<f64> {
        match self {
            Self::Free => None,
            Self::Fixed(value) => Some(value),
            Self::Low => Some(0.0),
            Self::High => Some(1.0),
        }
    }
}

/// The least wᵀQw with some values fixed and all from 0 to 1.
pub(super) fn minimise(q: &Symmetric, pattern: &Pattern, fixed: &[Option<f64>]) -> Result<Minimum, WeightsError> {
    let mut states: Vec<State> = fixed.iter().map(|value| value.map_or(State::Free, State::Fixed)).collect();
    let free: Vec<usize> = (0..fixed.len()).filter(|i| fixed[*i].is_none()).collect();
    let scale = free.iter().map(|i| q.diagonal(*i)).sum::<f64>() / free.len().max(1) as f64;
    let mut values = solve(q, pattern, &states)?;
    if free.iter().all(|i| (-LEAVES..=1.0 + LEAVES).contains(&values[*i])) {
        values.iter_mut().for_each(|w| *w = w.clamp(0.0, 1.0));
        return Ok(Minimum { values, rounds: 0, settled: true });
    }
    guess(q, pattern, &values, scale, &mut states)?;
    for rounds in 1..=ROUNDS {
        values = solve(q, pattern, &states)?;
        let pull = q.times(&values);
        let mut changed = false;
        for i in &free {
            let next = match states[*i] {
                State::Free if values[*i] < -LEAVES => State::Low,
                State::Free if values[*i] > 1.0 + LEAVES => State::High,
                State::Low if pull[*i] < -PULLS * scale => State::Free,
                State::High if pull[*i] > PULLS * scale => State::Free,
                same => same,
            };
            changed |= next != states[*i];
            states[*i] = next;
        }
        if !changed || rounds == ROUNDS {
            values.iter_mut().for_each(|w| *w = w.clamp(0.0, 1.0));
            return Ok(Minimum { values, rounds, settled: !changed });
        }
    }
    Err(WeightsError::Singular)
}

/// Solves for what is free.
fn solve(q: &Symmetric, pattern: &Pattern, states: &[State]) -> Result<Vec<f64>, WeightsError> {
    let factor = q.factor(pattern, 0.0, |i| states[i] != State::Free)?;
    let mut side = fixed_side(q, states);
    factor.solve(&mut side);
    Ok(side)
}

fn fixed_side(q: &Symmetric, states: &[State]) -> Vec<f64> {
    let of_row = |i: usize| match states[i].value() {
        Some(value) => value,
        None => -q.row(i).map(|(j, a)| a * states[j].value().unwrap_or(0.0)).sum::<f64>(),
    };
    (0..states.len()).map(of_row).collect()
}

/// Alternating directions of multipliers, over-relaxed: which values are at a bound.
fn guess(
    q: &Symmetric,
    pattern: &Pattern,
    start: &[f64],
    scale: f64,
    states: &mut [State],
) -> Result<(), WeightsError> {
    let (steps, share) = if states.len() < 10_000 { (50, 1e-3) } else { (200, 1e-4) };
    let rho = share * scale;
    let factor = q.factor(pattern, rho, |i| states[i] != State::Free)?;
    let side = fixed_side(q, states);
    let mut z: Vec<f64> = start.iter().map(|w| w.clamp(0.0, 1.0)).collect();
    let mut dual = vec![0.0; z.len()];
    let mut x = vec![0.0; z.len()];
    for _ in 0..steps {
        for (i, x) in x.iter_mut().enumerate() {
            *x = side[i] + if states[i] == State::Free { rho * (z[i] - dual[i]) } else { 0.0 };
        }
        factor.solve(&mut x);
        for i in 0..z.len() {
            let relaxed = 1.6 * x[i] - 0.6 * z[i];
            z[i] = (relaxed + dual[i]).clamp(0.0, 1.0);
            dual[i] += relaxed - z[i];
        }
    }
    for (i, state) in states.iter_mut().enumerate().filter(|(_, state)| **state == State::Free) {
        if z[i] <= 0.0 && dual[i] < 0.0 {
            *state = State::Low;
        } else if z[i] >= 1.0 && dual[i] > 0.0 {
            *state = State::High;
        }
    }
    Ok(())
}
