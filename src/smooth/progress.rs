//! Looking at a smoothing under way, and stopping it.

use std::ops::ControlFlow;

use super::{engine::Done, strip::Strip};

/// How far a smoothing is. How far it has to go nobody knows: rounds get cheaper as fewer vertices are left to pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SmoothProgress {
    /// How often vertices were passed, all that pressed at once, or sweeps: over all that was tried.
    pub rounds: u32,
    /// How many vertices were passed in what is tried now.
    pub flips: u32,
    /// Length of the line as it is now, in local units.
    pub length: f64,
}

/// Is asked whether to go on.
pub(crate) type Ask<'a> = &'a mut dyn FnMut(&SmoothProgress) -> ControlFlow<()>;

/// Who looks on while a line is smoothed.
pub(crate) struct Watch<'a> {
    /// Sees every line on the way.
    see: Option<&'a mut dyn FnMut(&Strip)>,
    /// Is asked whether to go on.
    ask: Option<Ask<'a>>,
    rounds: u32,
    stopped: bool,
    /// What was said last, and the work done since, in crossings moved.
    last: SmoothProgress,
    work: usize,
}

/// So much work is some milliseconds: who looks on is asked again within a round.
const LONG: usize = 50_000;

impl<'a> Watch<'a> {
    /// Nobody.
    pub(crate) fn nobody() -> Self {
        Self { see: None, ask: None, rounds: 0, stopped: false, last: SmoothProgress::default(), work: 0 }
    }

    /// Somebody who may stop it.
    pub(crate) fn asking(ask: Ask<'a>) -> Self {
        Self { ask: Some(ask), ..Self::nobody() }
    }

    /// Somebody who sees every line.
    #[cfg(test)]
    pub(crate) fn seeing(see: &'a mut dyn FnMut(&Strip)) -> Self {
        Self { see: Some(see), ..Self::nobody() }
    }

    /// Shows a line.
    pub(crate) fn see(&mut self, strip: &Strip) {
        if let Some(see) = &mut self.see {
            see(strip);
        }
    }

    /// Whether every step is to be seen.
    pub(crate) fn sees(&self) -> bool {
        self.see.is_some()
    }

    /// Asks whether to stop, after a round; once stopped it stays so.
    pub(crate) fn stops(&mut self, done: &Done, length: impl FnOnce() -> f64) -> bool {
        self.rounds += 1;
        if let (Some(ask), false) = (&mut self.ask, self.stopped) {
            self.last = SmoothProgress { rounds: self.rounds, flips: done.flips, length: length() };
            self.work = 0;
            self.stopped = ask(&self.last).is_break();
        }
        self.stopped
    }

    /// Asks whether to stop within a round, when so much work was done that somebody might wait.
    pub(crate) fn stops_within(&mut self, work: usize) -> bool {
        self.work += work;
        if let (Some(ask), false, true) = (&mut self.ask, self.stopped, self.work >= LONG) {
            self.work = 0;
            self.stopped = ask(&self.last).is_break();
        }
        self.stopped
    }

    /// Whether it was stopped.
    pub(crate) fn is_stopped(&self) -> bool {
        self.stopped
    }
}
