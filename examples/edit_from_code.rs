//! Editing by code, as the panel does it: one should see a sphere with a curve that grows an anchor, gets a corner, is turned, and
//! taken back again, a step a second; the title says what was done.
//!
//! `cargo run --features editor --example edit_from_code`

use bevy::prelude::*;
use bevy_egui::EguiPlugin;
use bevy_surface_splines::curve::SelectionTransform;
use bevy_surface_splines::editor::{Curve, EditorAction, Selection, SurfaceSplineEditorPlugin};
use bevy_surface_splines::plugin::DebugDrawPlugin;
use bevy_surface_splines::prelude::*;

fn main() -> AppExit {
    App::new()
        .add_plugins((DefaultPlugins, EguiPlugin::default()))
        .add_plugins((SurfaceSplinePlugins.build().disable::<DebugDrawPlugin>(), SurfaceSplineEditorPlugin))
        .add_systems(Startup, setup)
        .add_systems(Update, edit)
        .add_observer(|refused: On<SplineEditRefused>| warn!("{}", refused.reason))
        .run()
}

fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let grey = MeshMaterial3d(materials.add(Color::srgb(0.6, 0.62, 0.65)));
    let planet = commands.spawn((Mesh3d(meshes.add(Sphere::new(1.0))), grey, SplineSurface::default())).id();
    let through = [Vec3::new(-0.7, 0.2, 0.7), Vec3::new(0.0, 0.6, 0.8), Vec3::new(0.7, -0.2, 0.7)];
    let look =
        Curve { number: 0, name: "collar".into(), color: Color::WHITE, width: 3.0, hidden: false, locked: false };
    commands.spawn((OnSurface(planet), SplineSource::smooth_through(through), look));
    commands.spawn((DirectionalLight::default(), Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y)));
    commands.spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.5, 3.2).looking_at(Vec3::ZERO, Vec3::Y)));
}

/// A step a second: edits of one spline by messages, and what keys and panel would ask for.
fn edit(
    time: Res<Time>,
    mut step: Local<u32>,
    splines: Query<(Entity, &SurfaceSpline)>,
    mut selection: ResMut<Selection>,
    mut edits: MessageWriter<EditSpline>,
    mut actions: MessageWriter<EditorAction>,
    mut windows: Query<&mut Window>,
) {
    let Ok((entity, spline)) = splines.single() else { return };
    if time.elapsed_secs() < 1.0 + *step as f32 {
        return;
    }
    *step += 1;
    let centre = spline.anchors()[0].point();
    let mut send = |edit| {
        edits.write(EditSpline::new(entity, edit).undoable());
    };
    let said = match *step {
        1 => {
            selection.select(entity);
            "selected"
        }
        2 => {
            send(SplineEdit::Insert { at: SplineT(0.5) });
            "an anchor inserted"
        }
        3 => {
            send(SplineEdit::SetJoin { anchor: 2, join: Join::Corner });
            "a corner"
        }
        4 => {
            send(SplineEdit::Transform(SelectionTransform::rotation(centre, 0.5)));
            "turned about its first anchor"
        }
        5 => {
            actions.write(EditorAction::SetScheme(Scheme::lane_riesenfeld()));
            "traced by another scheme"
        }
        6..=9 => {
            actions.write(EditorAction::Undo);
            "taken back"
        }
        _ => return,
    };
    windows.iter_mut().for_each(|mut window| window.title = format!("collar: {said}"));
}
