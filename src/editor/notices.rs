//! Notices: short messages at the top right. Errors stay until they are dismissed.

use std::time::Duration;

use bevy::prelude::*;

use super::actions::EditorAction;

/// At most so many are shown: of more, the oldest that are no errors go.
const MOST: usize = 8;
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
#[derive(Clone, Debug, PartialEq)]
pub struct Notice {
    /// How bad it is.
    pub severity: Severity,
    /// What it says.
    pub text: String,
    /// A button, and what it asks for.
    pub button: Option<(&'static str, EditorAction)>,
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
        self.push(Severity::Info, text.into(), None);
    }

    /// Tells that something happened, instead of what was told in the same first words.
    pub fn info_instead(&mut self, first: &str, rest: &str) {
        self.0.retain(|notice| !notice.text.starts_with(first));
        self.info(format!("{first}{rest}"));
    }

    /// Tells that something is not as one would expect.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.push(Severity::Warning, text.into(), None);
    }

    /// Tells that something is not as one would expect, with a button.
    pub fn warn_with(&mut self, text: impl Into<String>, button: &'static str, action: EditorAction) {
        self.push(Severity::Warning, text.into(), Some((button, action)));
    }

    /// Tells that something could not be done, and what to do about it; it stays until it is dismissed.
    pub fn error(&mut self, text: impl Into<String>) {
        self.push(Severity::Error, text.into(), None);
    }

    /// A text that is shown already starts afresh.
    fn push(&mut self, severity: Severity, text: String, button: Option<(&'static str, EditorAction)>) {
        self.0.retain(|notice| notice.text != text);
        if self.0.len() >= MOST {
            let oldest = self.0.iter().position(|notice| notice.severity != Severity::Error);
            oldest.into_iter().for_each(|oldest| drop(self.0.remove(oldest)));
        }
        self.0.push(Notice { severity, text, button, age: Duration::ZERO });
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
        // What has a button may be wanted later.
        notice.severity == Severity::Error || notice.age < if notice.button.is_some() { 4 * SHOWN } else { SHOWN }
    });
}
