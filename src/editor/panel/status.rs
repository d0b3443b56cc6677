//! The status line: what the tool expects next.

use crate::prelude::*;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui;

use super::theme;
use crate::editor::curves::Curve;
use crate::editor::documents::{DocumentFile, FileRequest};
use crate::editor::model::Model;
use crate::editor::selection::Selection;
use crate::editor::tools::drawing::DrawingInHand;
use crate::editor::tools::freehand::Freehand;
use crate::editor::tools::gizmo::GizmoPart;
use crate::editor::tools::pen::PenStart;
use crate::editor::tools::pointer::Target;
use crate::editor::tools::transform::{Active, TransformMode, Transforming};
use crate::editor::tools::{Tool, ToolPointer};

use super::properties::significant;

const HEIGHT: f32 = 30.0;

/// What the line depends on.
#[derive(SystemParam)]
pub(crate) struct Status<'w, 's> {
    tool: Res<'w, Tool>,
    pen: Res<'w, PenStart>,
    transforming: Res<'w, Transforming>,
    freehand: Res<'w, Freehand>,
    files: Option<Res<'w, DocumentFile>>,
    hand: Res<'w, DrawingInHand>,
    pointer: Res<'w, ToolPointer>,
    curves: Query<'w, 's, &'static Curve>,
    drag: Res<'w, DragState>,
    selection: Res<'w, Selection>,
    models: Query<'w, 's, (), With<Model>>,
    surfaces: Query<'w, 's, &'static SurfaceState>,
    splines: Query<'w, 's, &'static SurfaceSpline>,
    under_way: Query<'w, 's, (&'static SplineState, Has<PendingEdit>)>,
}

impl Status<'_, '_> {
    /// What is done in the background with files, and can be stopped.
    fn working(&self) -> Option<&'static str> {
        self.files.as_ref()?.working()
    }

    pub(crate) fn tool(&self) -> Tool {
        *self.tool
    }

    /// What the tool expects next, and whether curves are on their way.
    fn text(&self, draws_lines: bool) -> String {
        let building = self.surfaces.iter().find_map(|state| match state {
            SurfaceState::Pending { progress } => Some(*progress),
            _ => None,
        });
        if let Some(working) = self.working() {
            return building.map_or(working.into(), |share| format!("{working} {:.0} %", 100.0 * share));
        }
        let is_tracing = self.under_way.iter().any(|(state, pending)| pending || *state == SplineState::Tracing);
        let suffix = if is_tracing { " · tracing …" } else { "" };
        self.hint(draws_lines) + suffix
    }

    /// The name of the curve that the pen goes on with; a closed one is done, and so is one that is not there any more.
    fn continued(&self) -> Option<&str> {
        let entity = self.pen.continues()?;
        let spline = self.splines.get(entity).ok()?;
        Some(self.curves.get(entity).ok()?.name.as_str()).filter(|_| !spline.is_closed())
    }

    fn hint(&self, draws_lines: bool) -> String {
        if let Some(SurfaceState::Pending { progress }) =
            self.surfaces.iter().find(|state| matches!(state, SurfaceState::Pending { .. }))
        {
            return format!("Building the surface … {:.0} %", 100.0 * progress);
        }
        if self.models.is_empty() {
            return "Reading the model …".into();
        }
        if let Some(active) = &self.transforming.0 {
            return transform_hint(active);
        }
        if self.freehand.is_fitting() {
            return "Fitting a spline to the line …".into();
        }
        if let Some(grip) = self.drag.dragged() {
            let what = match grip.kind {
                ControlKind::Anchor(i) => format!("anchor {}", i + 1),
                ControlKind::Handle(i, _) => format!("a handle of anchor {}", i + 1),
            };
            return format!("Dragging {what}: release to keep, Escape to take back");
        }
        if let Some(Target::Gizmo(part)) = self.pointer.hover.map(|moment| moment.target) {
            return match part {
                GizmoPart::Ring => "Drag the ring to turn the selection · R by a number",
                GizmoPart::Knob => "Drag the knob to scale the selection · S by a number",
                GizmoPart::Middle => "Drag the cross to move the selection · G by a number",
            }
            .into();
        }
        let spline = self.selection.spline().and_then(|entity| self.splines.get(entity).ok());
        match (*self.tool, spline) {
            (Tool::Pen, _) if self.pen.0.is_some() => "Click on the model: the second point · drag for a smooth one",
            (Tool::Pen, _) if self.continued().is_some() => {
                let name = self.continued().unwrap_or_default();
                return format!(
                    "Continues {name}: click adds a corner, drag a smooth anchor · click its first anchor to close · Enter ends"
                );
            }
            (Tool::Pen, _) => {
                "Click on the model to begin a curve, drag for a smooth anchor; click the last anchor of a curve to continue it"
            }
            (Tool::Freehand, _) if draws_lines => {
                "Drag on the model to draw; the line can be smoothed in the panel · V selects"
            }
            (Tool::Freehand, _) => "Drag on the model to draw; the line becomes a spline · V selects",
            (Tool::Insert, _) => "Click on a curve to add an anchor there · V selects",
            (Tool::Join, Some(_)) => "Click on an anchor to change its join: corner, smooth, mirrored, automatic",
            (Tool::Join, None) => "Click on a curve to see its anchors",
            (Tool::Drawing, _) if self.hand.is_busy() => "Reading and placing the drawing …",
            (Tool::Drawing, _) if self.hand.name().is_some() => {
                "Click places the drawing · wheel scales · Shift and wheel turn · V ends"
            }
            (Tool::Brush, _) => {
                "Drag along a drawn line to smooth it there · radius and strength are in the Scene tab · V selects"
            }
            (Tool::Drawing, _) => "Choose an SVG in the panel, or drop one on the window",
            (Tool::Select, Some(spline)) if spline.scheme().method.is_b_spline() => {
                "Drag a control point of the B-spline over the surface · X deletes the selected one · ? shows all keys"
            }
            (Tool::Select, Some(_)) if self.selection.anchors().len() > 1 => {
                "Drag moves all selected anchors · G moves, R turns, S scales · X deletes · ? shows all keys"
            }
            (Tool::Select, Some(_)) if self.selection.anchor().is_some() => {
                "Drag anchors and handles · C changes the join · X deletes the anchor · ? shows all keys"
            }
            (Tool::Select, Some(_)) => {
                "Drag an anchor, a handle or the whole curve · middle drag orbits · ? shows all keys"
            }
            (Tool::Select, None) => {
                "Click a curve to edit it · P takes the pen · middle drag orbits · ? shows all keys"
            }
        }
        .into()
    }
}

/// What is done, by how much, and how it ends.
fn transform_hint(active: &Active) -> String {
    let what = match active.mode {
        TransformMode::Move => "Moving by",
        TransformMode::Turn => "Turning by",
        TransformMode::Scale => "Scaling by",
    };
    let unit = if active.mode == TransformMode::Turn { "°" } else { "" };
    let typed = if active.typed.is_empty() { significant(active.amount, 4) } else { format!("{}|", active.typed) };
    format!(
        "{what} {typed}{unit} · type a number · Shift finer, Ctrl in steps · click or Enter keeps, Escape takes back"
    )
}

/// Shows the line at the bottom of a part of the window; gives its upper edge. Freehand may draw lines instead of splines.
pub(crate) fn show(
    ctx: &egui::Context,
    part: egui::Rect,
    (status, draws_lines): (&Status, bool),
    requests: Option<&mut MessageWriter<FileRequest>>,
) -> f32 {
    let top = part.bottom() - HEIGHT;
    egui::Area::new("status".into()).fixed_pos(egui::pos2(part.left(), top)).show(ctx, |ui| {
        theme::panel().inner_margin(egui::Margin::symmetric(14, 0)).show(ui, |ui| {
            ui.set_min_size(egui::vec2(part.width() - 30.0, HEIGHT - 2.0));
            ui.set_max_size(egui::vec2(part.width() - 30.0, HEIGHT - 2.0));
            ui.horizontal_centered(|ui| {
                if let Some(requests) = requests.filter(|_| status.working().is_some()) {
                    ui.spinner();
                    if ui.small_button("Cancel").clicked() {
                        requests.write(FileRequest::Cancel);
                    }
                }
                ui.add(egui::Label::new(status.text(draws_lines)).truncate())
            });
        });
    });
    top
}
