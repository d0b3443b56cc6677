//! Notices: short messages at the top right. Errors stay until they are dismissed.

use std::time::Duration;

use bevy::prelude::*;

/// How long a notice that is no error stays.
const SHOWN: Duration = Duration::from_secs(8);

/// How bad a notice is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Something happened.
    Info,
    /// Something is not as one would expect.
    Warning,
    /// Something could not be done.
    Error,
}

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// How bad it is.
    pub severity: Severity,
    /// What it says.
    pub text: String,
    age: Duration,
}

/// What the user should be told.
#[derive(Resource, Debug, Default)]
pub struct Notices(Vec<Notice>);

impl Notices {
    /// All that are shown, the oldest first.
    pub fn all(&self) -> &[Notice] {
        &self.0
    }

    /// Takes one away, by its place.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.0.len() {
            self.0.remove(index);
        }
    }

    /// Tells that something happened.
    pub fn info(&mut self, text: impl Into<String>) {
        self.push(Severity::Info, text.into());
    }

    /// Tells that something is not as one would expect.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.push(Severity::Warning, text.into());
    }

    /// Tells that something could not be done, and what to do about it; it stays until it is dismissed.
    pub fn error(&mut self, text: impl Into<String>) {
        self.push(Severity::Error, text.into());
    }

    /// A text that is shown already starts afresh.
    fn push(&mut self, severity: Severity, text: String) {
        self.0.retain(|notice| notice.text != text);
        self.0.push(Notice { severity, text, age: Duration::ZERO });
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Notices>().add_systems(Update, forget_old);
}

fn forget_old(mut notices: ResMut<Notices>, time: Res<Time<Real>>) {
    if notices.0.is_empty() {
        return;
    }
    // A slow frame must not swallow what nobody could have read.
    let step = time.delta().min(Duration::from_millis(100));
    notices.0.retain_mut(|notice| {
        notice.age += step;
        notice.severity == Severity::Error || notice.age < SHOWN
    });
}
