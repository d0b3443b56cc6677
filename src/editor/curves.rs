//! Splines and drawn lines as the editor knows them: with a name and a look, hidden, locked, or taken off their surface.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;

use crate::curve::Spline;
use crate::plugin::{Editable, LineSmoothing, OnSurface, SplineTrace, SurfaceLine, SurfaceSpline};

use super::colors;

/// A spline or a line in the editor's list: its name and its look. Those without it are shown, but not listed.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, Clone, Debug, PartialEq)]
#[require(Visibility)]
pub struct Curve {
    /// Counts up; lists are in this order.
    pub number: u32,
    /// What the user calls it.
    pub name: String,
    /// Its colour where it is not selected.
    pub color: Color,
    /// Width of its line, in logical pixels.
    pub width: f32,
    /// Whether it is shown, and can be picked.
    pub hidden: bool,
    /// Whether tools leave it alone.
    pub locked: bool,
}

impl Curve {
    /// Width of the line of a curve for which nothing else was asked, in logical pixels.
    pub const WIDTH: f32 = 2.5;

    /// Whether tools may touch it.
    pub fn is_free(&self) -> bool {
        !self.hidden && !self.locked
    }
}

/// What lies on the surface: a spline, or a line with how it is smoothed.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Content {
    Spline(Spline),
    Line(SurfaceLine, Option<LineSmoothing>),
}

/// A spline or a line that was removed and may be brought back by undo: it keeps its entity, so that the history stays true.
#[derive(Component, Clone, Debug)]
pub(crate) struct Shelved {
    pub(crate) content: Content,
    pub(crate) on: Entity,
}

/// All lines that lie on surfaces.
pub(crate) type Lines<'w, 's> =
    Query<'w, 's, (&'static SurfaceLine, Option<&'static LineSmoothing>, &'static OnSurface), With<Curve>>;

/// The number of the next curve.
#[derive(Resource, Debug, Default)]
pub(crate) struct NextNumber(pub(crate) u32);

/// Spawns splines that the editor lists, as a system parameter; the history does not remember them.
#[derive(SystemParam)]
pub struct CurveSpawner<'w, 's> {
    commands: Commands<'w, 's>,
    next: ResMut<'w, NextNumber>,
}

impl CurveSpawner<'_, '_> {
    /// Spawns a spline on the surface of an entity, named after its number unless it has a name.
    pub fn spawn(&mut self, on: Entity, name: Option<&str>, spline: Spline) -> Entity {
        let curve = self.next.curve(name);
        spawn(&mut self.commands, on, curve, spline)
    }
}

impl NextNumber {
    /// A curve of the next number, named after it unless it has a name.
    pub(crate) fn curve(&mut self, name: Option<&str>) -> Curve {
        let number = self.0;
        self.0 = self.0.wrapping_add(1);
        let name = name.map_or_else(|| format!("Curve {}", u64::from(number) + 1), str::to_string);
        let color = colors::CURVES[number as usize % colors::CURVES.len()];
        Curve { number, name, color, width: Curve::WIDTH, hidden: false, locked: false }
    }
}

/// Spawns a spline on a model.
pub(crate) fn spawn(commands: &mut Commands, on: Entity, curve: Curve, spline: Spline) -> Entity {
    let visibility = visibility_of(&curve);
    commands.spawn((OnSurface(on), SurfaceSpline::new(spline), curve, visibility, Pickable::default())).id()
}

/// Spawns a line on a model.
pub(crate) fn spawn_line(
    commands: &mut Commands,
    on: Entity,
    curve: Curve,
    line: SurfaceLine,
    smoothing: Option<LineSmoothing>,
) -> Entity {
    let visibility = visibility_of(&curve);
    let mut spawned = commands.spawn((OnSurface(on), line, curve, visibility, Pickable::default()));
    smoothing.into_iter().for_each(|smoothing| {
        spawned.insert(smoothing);
    });
    spawned.id()
}

fn visibility_of(curve: &Curve) -> Visibility {
    if curve.hidden { Visibility::Hidden } else { Visibility::Inherited }
}

/// Keeps what can be seen and picked in step with what curves say.
pub(crate) fn show_or_hide(
    mut commands: Commands,
    mut curves: Query<(Entity, &Curve, &mut Visibility, Has<Pickable>), Changed<Curve>>,
) {
    for (entity, curve, mut visibility, pickable) in &mut curves {
        visibility.set_if_neq(visibility_of(curve));
        if curve.is_free() && !pickable {
            commands.entity(entity).try_insert(Pickable::default());
        } else if !curve.is_free() && pickable {
            commands.entity(entity).try_remove::<Pickable>();
        }
    }
}

/// Takes a spline or a line off its surface.
pub(crate) fn shelve(commands: &mut Commands, entity: Entity, content: Content, on: Entity) {
    commands
        .entity(entity)
        .try_remove::<(SurfaceSpline, SplineTrace, SurfaceLine, LineSmoothing, OnSurface, Editable)>()
        .try_insert(Shelved { content, on });
}

/// Puts it back.
pub(crate) fn unshelve(commands: &mut Commands, entity: Entity, shelved: &Shelved) {
    let mut entity = commands.entity(entity);
    entity.try_remove::<Shelved>().try_insert(OnSurface(shelved.on));
    match shelved.content.clone() {
        Content::Spline(spline) => {
            entity.try_insert(SurfaceSpline::new(spline));
        }
        Content::Line(line, smoothing) => set_line(&mut entity, line, smoothing),
    }
}

/// Gives a line another course, and another way of smoothing.
pub(crate) fn set_line(entity: &mut EntityCommands, line: SurfaceLine, smoothing: Option<LineSmoothing>) {
    entity.try_insert(line);
    match smoothing {
        Some(smoothing) => entity.try_insert(smoothing),
        None => entity.try_remove::<LineSmoothing>(),
    };
}
