//! Splines become lines, and lines splines: the one that was goes, and the one that comes has its name and look, as one entry of the history.

use std::sync::Arc;

use bevy::prelude::*;
use bevy::tasks::{Task, block_on, futures_lite::future};

use super::curves::{self, Content, Curve, NextNumber};
use super::documents::spawn;
use super::history::History;
use super::notices::Notices;
use super::selection::Selection;
use super::tools::freehand::FreehandSettings;
use crate::curve::{FitOptions, Spline, TraceWorkspace};
use crate::plugin::{BuiltSurface, LineSmoothing, OnSurface, SmoothedLine, SplineTrace, SurfaceLine, SurfaceSpline};
use crate::smooth::{Smoothed, SurfacePolyline};
use crate::surface::Surface;

/// Asks to make lines of splines, or splines of lines.
#[derive(Message, Clone, Debug)]
pub(crate) struct Convert {
    pub(crate) to_splines: bool,
    pub(crate) entities: Vec<Entity>,
}

/// Lines to which splines are being fitted, in the background.
#[derive(Resource, Default)]
pub struct Conversions(Vec<Conversion>);

struct Conversion {
    line: Entity,
    task: Task<Result<Spline, String>>,
}

impl Conversions {
    /// Whether a spline is being fitted.
    pub fn is_busy(&self) -> bool {
        !self.0.is_empty()
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Conversions>().add_message::<Convert>().add_systems(Update, (begin, collect).chain());
}

type Splines<'w, 's> = Query<'w, 's, (&'static SurfaceSpline, &'static SplineTrace, &'static OnSurface)>;
type Lines<'w, 's> =
    Query<'w, 's, (&'static SurfaceLine, Option<&'static LineSmoothing>, &'static SmoothedLine, &'static OnSurface)>;

/// What conversions need.
#[derive(bevy::ecs::system::SystemParam)]
struct Desk<'w, 's> {
    commands: Commands<'w, 's>,
    history: ResMut<'w, History>,
    notices: ResMut<'w, Notices>,
    selection: ResMut<'w, Selection>,
    next: ResMut<'w, NextNumber>,
    splines: Splines<'w, 's>,
    lines: Lines<'w, 's>,
    curves: Query<'w, 's, &'static Curve>,
    surfaces: Query<'w, 's, &'static BuiltSurface>,
}

fn begin(
    mut asked: MessageReader<Convert>,
    mut desk: Desk,
    mut conversions: ResMut<Conversions>,
    settings: Option<Res<FreehandSettings>>,
) {
    let tolerance = settings.map_or_else(FreehandSettings::default, |settings| *settings).tolerance;
    for Convert { to_splines, entities } in asked.read() {
        let mut found = false;
        for entity in entities {
            found |= if *to_splines {
                desk.begin_spline(*entity, tolerance, &mut conversions)
            } else {
                desk.make_line(*entity)
            };
        }
        if !found {
            desk.notices.info(if *to_splines {
                "Select a drawn line first: a spline is fitted to it."
            } else {
                "Select a spline first: a line that can be smoothed is made along it."
            });
        }
    }
}

/// Takes over the splines that were fitted.
fn collect(mut conversions: ResMut<Conversions>, mut desk: Desk) {
    if conversions.0.is_empty() {
        return;
    }
    conversions.0.retain_mut(|conversion| {
        let Some(result) = block_on(future::poll_once(&mut conversion.task)) else { return true };
        match result {
            Ok(spline) => desk.finish_spline(conversion.line, spline),
            Err(reason) => desk.notices.warn(reason),
        }
        false
    });
}

impl Desk<'_, '_> {
    fn make_line(&mut self, entity: Entity) -> bool {
        let Ok((spline, trace, on)) = self.splines.get(entity) else { return false };
        let Ok(surface) = self.surfaces.get(on.0) else { return false };
        match SurfacePolyline::along(surface, trace.trace(), spline.is_closed()) {
            Ok(line) => {
                let (content, on) = (Content::Spline((**spline).clone()), on.0);
                self.history.begin("Make a line");
                let curve = self.replace(entity, content, on);
                let line = curves::spawn_line(&mut self.commands, on, curve, SurfaceLine::new(line), None);
                self.history.note_added("Make a line", line);
                self.history.end();
                self.selection.select(line);
            }
            Err(error) => self.notices.warn(error.to_string()),
        }
        true
    }

    fn begin_spline(&mut self, entity: Entity, tolerance: f64, conversions: &mut Conversions) -> bool {
        let Ok((_, _, smoothed, on)) = self.lines.get(entity) else { return false };
        let Ok(surface) = self.surfaces.get(on.0) else { return false };
        if conversions.0.iter().any(|conversion| conversion.line == entity) {
            return true;
        }
        let (surface, shown) = (surface.0.clone(), smoothed.smoothed().clone());
        let options = FitOptions::within(tolerance * surface.diagonal());
        conversions.0.push(Conversion { line: entity, task: spawn(move || fit(&surface, &shown, &options)) });
        true
    }

    fn finish_spline(&mut self, entity: Entity, spline: Spline) {
        let Ok((line, smoothing, _, on)) = self.lines.get(entity) else { return };
        let (content, on) = (Content::Line(line.clone(), smoothing.copied()), on.0);
        self.history.begin("Make a spline");
        let curve = self.replace(entity, content, on);
        let spline = curves::spawn(&mut self.commands, on, curve, spline);
        self.history.note_added("Make a spline", spline);
        self.history.end();
        self.selection.select(spline);
    }

    /// Takes something off its surface; gives name and look for what comes in its place.
    fn replace(&mut self, entity: Entity, content: Content, on: Entity) -> Curve {
        let new = self.next.curve(None);
        let curve = self.curves.get(entity).map_or(new.clone(), |old| Curve { number: new.number, ..old.clone() });
        curves::shelve(&mut self.commands, entity, content, on);
        self.history.note_removed("Remove", entity);
        curve
    }
}

fn fit(surface: &Surface, shown: &Arc<Smoothed>, options: &FitOptions) -> Result<Spline, String> {
    let drawn = shown.line.to_drawn(surface).map_err(|error| error.to_string())?;
    let fit = Spline::fit(surface, &mut TraceWorkspace::default(), &drawn, options);
    fit.map(|fit| fit.spline).map_err(|error| error.to_string())
}
