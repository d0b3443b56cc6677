//! Notices: short messages at the top right. Errors stay until they are dismissed.

use std::time::Duration;

use bevy::prelude::*;
use bevy_egui::egui;

use crate::theme;

/// How long a notice that is no error stays.
const SHOWN: Duration = Duration::from_secs(8);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Severity {
    Info,
    Warning,
    Error,
}

#[derive(Debug)]
struct Notice {
    severity: Severity,
    text: String,
    age: Duration,
}

/// What the user should be told.
#[derive(Resource, Debug, Default)]
pub(crate) struct Notices(Vec<Notice>);

impl Notices {
    pub(crate) fn info(&mut self, text: impl Into<String>) {
        self.push(Severity::Info, text.into());
    }

    pub(crate) fn warn(&mut self, text: impl Into<String>) {
        self.push(Severity::Warning, text.into());
    }

    pub(crate) fn error(&mut self, text: impl Into<String>) {
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

/// Shows the notices with their right edge at `right`.
pub(crate) fn show(ctx: &egui::Context, right: f32, notices: &mut Notices) {
    let mut dismissed = None;
    egui::Area::new("notices".into())
        .order(egui::Order::Foreground)
        .pivot(egui::Align2::RIGHT_TOP)
        .fixed_pos(egui::pos2(right - 12.0, 12.0))
        .show(ctx, |ui| {
            for (index, notice) in notices.0.iter().enumerate() {
                if show_one(ui, notice) {
                    dismissed = Some(index);
                }
                ui.add_space(6.0);
            }
        });
    if let Some(index) = dismissed {
        notices.0.remove(index);
    }
}

/// Shows a notice; whether it was dismissed.
fn show_one(ui: &mut egui::Ui, notice: &Notice) -> bool {
    let (sign, color) = match notice.severity {
        Severity::Info => ("i", theme::INFO),
        Severity::Warning => ("!", theme::WARNING),
        Severity::Error => ("×", theme::ERROR),
    };
    let mut dismissed = false;
    theme::card().stroke(egui::Stroke::new(1.0, color)).show(ui, |ui| {
        ui.set_width(300.0);
        ui.horizontal_top(|ui| {
            ui.label(egui::RichText::new(sign).strong().color(color));
            ui.vertical(|ui| {
                ui.set_width(250.0);
                ui.add(egui::Label::new(&notice.text).wrap());
            });
            dismissed = ui.small_button("×").on_hover_text("Dismiss").clicked();
        });
    });
    dismissed
}
