//! What is around the model: lights that go with the camera, and a soft backdrop.

use bevy::asset::RenderAssetUsages;
use bevy::camera::visibility::NoFrustumCulling;
use bevy::core_pipeline::tonemapping::DebandDither;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;

use crate::editor::camera::Orbit;
use crate::editor::model::{Candidate, Model};

pub(crate) fn plugin(app: &mut App) {
    app.insert_resource(GlobalAmbientLight { color: Color::srgb(0.85, 0.9, 1.0), brightness: 260.0, ..default() })
        .insert_resource(ClearColor(Color::srgb(0.16, 0.18, 0.21)))
        .init_resource::<StageSettings>()
        .add_systems(Startup, set_stage)
        .add_systems(PostUpdate, give_material);
}

/// How the stage is set.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageSettings {
    /// Whether edges are smoothed and shades dithered; a software driver draws several times faster without, and pictures take less
    /// room.
    pub smooth_edges: bool,
}

impl Default for StageSettings {
    fn default() -> Self {
        Self { smooth_edges: true }
    }
}

/// A matt material that shows shape, from either side.
fn clay() -> StandardMaterial {
    StandardMaterial {
        base_color: Color::srgb(0.66, 0.68, 0.71),
        perceptual_roughness: 0.75,
        reflectance: 0.35,
        double_sided: true,
        cull_mode: None,
        ..default()
    }
}

/// Models, opened and about to be, without a material.
type Bare<'w, 's> =
    Query<'w, 's, Entity, (Or<(With<Model>, With<Candidate>)>, Without<MeshMaterial3d<StandardMaterial>>)>;

/// Models come without a material.
fn give_material(mut commands: Commands, models: Bare, mut materials: ResMut<Assets<StandardMaterial>>) {
    for model in &models {
        commands.entity(model).try_insert(MeshMaterial3d(materials.add(clay())));
    }
}

fn set_stage(
    mut commands: Commands,
    settings: Res<StageSettings>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let (msaa, dither) = if settings.smooth_edges {
        (Msaa::Sample4, DebandDither::Enabled)
    } else {
        (Msaa::Off, DebandDither::Disabled)
    };
    let backdrop = (
        Mesh3d(meshes.add(backdrop_mesh())),
        MeshMaterial3d(materials.add(StandardMaterial { unlit: true, fog_enabled: false, ..default() })),
        NoFrustumCulling,
    );
    commands.spawn((msaa, dither, Orbit::default())).with_children(|rig| {
        let mut light = |from: Vec3, illuminance: f32, color: Color| {
            let toward = Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y);
            rig.spawn((DirectionalLight { illuminance, color, ..default() }, toward));
        };
        light(Vec3::new(-1.2, 1.6, 1.4), 5_200.0, Color::srgb(1.0, 0.97, 0.92)); // key
        light(Vec3::new(1.8, 0.2, 1.0), 1_500.0, Color::srgb(0.84, 0.9, 1.0)); // fill
        light(Vec3::new(0.4, 0.9, -1.6), 2_600.0, Color::WHITE); // rim
        rig.spawn(backdrop);
    });
}

/// A wall far behind everything, lighter in the middle, that fills the view of the camera it hangs on.
fn backdrop_mesh() -> Mesh {
    const RINGS: u32 = 10;
    const SECTORS: u32 = 40;
    const DISTANCE: f32 = 150.0;
    const RADIUS: f32 = 160.0;
    let (inner, outer) = (Color::srgb(0.37, 0.40, 0.45), Color::srgb(0.13, 0.145, 0.17));
    let (mut positions, mut colors, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for ring in 0..=RINGS {
        let share = ring as f32 / RINGS as f32;
        // Smooth at both ends.
        let fade = share * share * (3.0 - 2.0 * share);
        let color = Oklaba::from(inner).mix(&Oklaba::from(outer), fade);
        for sector in 0..SECTORS {
            let at = RADIUS * share * Vec2::from_angle(sector as f32 / SECTORS as f32 * std::f32::consts::TAU);
            positions.push([at.x, at.y, -DISTANCE]);
            colors.push(LinearRgba::from(color).to_f32_array());
        }
    }
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let (here, there) = (ring * SECTORS, (ring + 1) * SECTORS);
            let (left, right) = (sector, (sector + 1) % SECTORS);
            indices.extend([here + left, there + left, there + right, here + left, there + right, here + right]);
        }
    }
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::RENDER_WORLD)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0, 0.0, 1.0]; positions.len()])
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colors)
        .with_inserted_indices(Indices::U32(indices))
}
