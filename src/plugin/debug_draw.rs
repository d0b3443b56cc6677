//! Splines and lines drawn with gizmos: curves, the legs of handles or of control polygons, and marks for control points.

use bevy::gizmos::GizmoPlugin;
use bevy::prelude::*;

use super::SurfaceSplineSystems;
use super::controls::{ControlKind, Editable};
use super::edit_queue::PendingEdit;
use super::polygon::ControlPolygon;
use super::preview::TracePreview;
use super::queries::{SurfaceQueries, SurfaceView};
use super::riding::RidingCurve;
use super::smoothed_line::SmoothedLine;
use super::spline::SurfaceSpline;
use super::surface::OnSurface;
use super::trace::SplineTrace;
use crate::curve::{Anchor, Join};
use crate::geodesic::GeodesicPath;

/// The gizmo group of splines and lines; its `GizmoConfig` says whether they are drawn, and how wide lines are.
#[derive(Reflect, GizmoConfigGroup, Clone, Copy, Debug, PartialEq)]
#[reflect(Default, Clone, Debug, PartialEq)]
pub struct SplineGizmos {
    /// Curves.
    pub curve: Color,
    /// What previews of curves keep of their opacity, which says that they are rough or outdated.
    pub preview: f32,
    /// Lines.
    pub line: Color,
    /// Lines as they were drawn, where they are smoothed; transparent: they are not drawn.
    pub drawn_line: Color,
    /// The geodesic curvature (one over local units) at which a line has the colours of [`turns`](Self::turns); less is between
    /// these and [`line`](Self::line). None: lines have one colour.
    pub full_curvature: Option<f32>,
    /// What lines are coloured by where they turn to the right, and to the left.
    pub turns: [Color; 2],
    /// Legs from anchors to handles, and those of the control polygons of B-splines.
    pub leg: Color,
    /// Anchors and handles.
    pub control: Color,
    /// Width of anchors, in logical pixels.
    pub anchor_size: f32,
    /// Width of handles, in logical pixels.
    pub handle_size: f32,
}

impl Default for SplineGizmos {
    fn default() -> Self {
        Self {
            curve: Color::srgb(1.0, 0.6, 0.1),
            preview: 0.5,
            line: Color::srgb(0.95, 0.9, 0.4),
            drawn_line: Color::srgba(0.8, 0.8, 0.8, 0.4),
            full_curvature: None,
            turns: [Color::srgb(0.15, 0.45, 1.0), Color::srgb(1.0, 0.2, 0.15)],
            leg: Color::srgb(0.5, 0.7, 0.9),
            control: Color::WHITE,
            anchor_size: 9.0,
            handle_size: 7.0,
        }
    }
}

/// Draws every traced spline, or its [`TracePreview`] while there is one; of [`Editable`] ones also the control points: squares for corners, discs for other anchors,
/// small discs for handles, joined to their anchors by their geodesics. Anchors of a B-spline are discs, joined by its control
/// polygon. Where a curve is torn, it is drawn torn. Of a line its [`SmoothedLine`] is drawn, by its curvature if that is wished for.
///
/// Schedule: `PostUpdate`, set [`SurfaceSplineSystems::Draw`]. Needs Bevy's `GizmoPlugin`; without it nothing is drawn.
#[derive(Debug, Default)]
pub struct DebugDrawPlugin;

impl Plugin for DebugDrawPlugin {
    fn build(&self, app: &mut App) {
        super::configure_sets(app);
        app.register_type::<SplineGizmos>();
    }

    fn finish(&self, app: &mut App) {
        if !app.is_plugin_added::<GizmoPlugin>() {
            return;
        }
        // A little towards the eye, so that lines do not fight with the faces they lie on.
        let line = GizmoLineConfig { width: 2.0, ..default() };
        app.insert_gizmo_config(SplineGizmos::default(), GizmoConfig { depth_bias: -0.002, line, ..default() })
            .add_systems(
                PostUpdate,
                (draw_curves, draw_lines, draw_polygons, draw_controls).in_set(SurfaceSplineSystems::Draw),
            );
    }
}

fn draw_curves(
    mut gizmos: Gizmos<SplineGizmos>,
    surfaces: SurfaceQueries,
    traces: Query<(&SplineTrace, &OnSurface, Option<&RidingCurve>), Without<TracePreview>>,
    previews: Query<(&TracePreview, &OnSurface)>,
) {
    if !gizmos.config.enabled {
        return;
    }
    let color = gizmos.config_ext.curve;
    for (trace, on, riding) in &traces {
        match riding {
            Some(riding) => riding.pieces().for_each(|piece| gizmos.linestrip(piece.iter().copied(), color)),
            None => draw_pieces(&mut gizmos, &surfaces, on.0, trace.pieces(), color),
        }
    }
    let dim = color.with_alpha(color.alpha() * gizmos.config_ext.preview);
    for (preview, on) in &previews {
        draw_pieces(&mut gizmos, &surfaces, on.0, preview.pieces(), dim);
    }
}

fn draw_lines(mut gizmos: Gizmos<SplineGizmos>, surfaces: SurfaceQueries, lines: Query<(&SmoothedLine, &OnSurface)>) {
    if !gizmos.config.enabled {
        return;
    }
    let style = *gizmos.config_ext;
    for (line, on) in &lines {
        let Some(view) = surfaces.get(on.0) else { continue };
        let world = |p: &Vec3| view.seen(*p);
        if line.by().is_some() && !style.drawn_line.is_fully_transparent() {
            gizmos.linestrip(line.drawn_polyline().iter().map(world), style.drawn_line);
        }
        match style.full_curvature {
            Some(most) => {
                let colors = [style.turns[0], style.line, style.turns[1]];
                gizmos.linestrip_gradient(line.colored(colors, most).map(|(p, color)| (world(&p), color)));
            }
            None => gizmos.linestrip(line.polyline().iter().map(world), style.line),
        }
    }
}

fn draw_pieces<'p>(
    gizmos: &mut Gizmos<SplineGizmos>,
    surfaces: &SurfaceQueries,
    on: Entity,
    pieces: impl Iterator<Item = &'p [Vec3]>,
    color: Color,
) {
    let Some(view) = surfaces.get(on) else { return };
    for piece in pieces {
        gizmos.linestrip(piece.iter().map(|p| view.seen(*p)), color);
    }
}

fn draw_polygons(
    mut gizmos: Gizmos<SplineGizmos>,
    surfaces: SurfaceQueries,
    polygons: Query<(&ControlPolygon, &OnSurface), With<Editable>>,
) {
    if !gizmos.config.enabled {
        return;
    }
    let color = gizmos.config_ext.leg;
    for (polygon, on) in &polygons {
        let Some(view) = surfaces.get(on.0) else { continue };
        for leg in polygon.legs() {
            gizmos.linestrip(leg.iter().map(|p| view.seen(*p)), color);
        }
    }
}

fn draw_controls(
    mut gizmos: Gizmos<SplineGizmos>,
    surfaces: SurfaceQueries,
    splines: Query<(&SurfaceSpline, &OnSurface, Option<&PendingEdit>), With<Editable>>,
    cameras: Query<(&Camera, &GlobalTransform)>,
) {
    let shown = cameras.iter().filter(|(camera, _)| camera.is_active).min_by_key(|(camera, _)| camera.order);
    let Some((camera, eye)) = shown.filter(|_| gizmos.config.enabled) else { return };
    for (spline, on, pending) in &splines {
        let Some(view) = surfaces.get(on.0) else { continue };
        let has_joins = !spline.scheme().method.is_b_spline();
        for kind in ControlKind::all(spline) {
            let Some(point) = kind.shown(spline, pending) else { continue };
            let position = view.position(point);
            let Some(pixel) = world_per_pixel(camera, eye, position) else { continue };
            let place = Isometry3d::new(position, eye.rotation());
            let style = *gizmos.config_ext;
            match (kind, leg(spline.anchors(), kind)) {
                (ControlKind::Anchor(i), _) if has_joins && spline.anchors()[i as usize].join() == Join::Corner => {
                    gizmos.rect(place, Vec2::splat(style.anchor_size * pixel), style.control);
                }
                (ControlKind::Anchor(_), _) => disc(&mut gizmos, place, 0.5 * style.anchor_size * pixel, style.control),
                (ControlKind::Handle(..), leg) => {
                    disc(&mut gizmos, place, 0.5 * style.handle_size * pixel, style.control);
                    gizmos.linestrip(leg.into_iter().flat_map(|leg| world_positions(leg, &view)), style.leg);
                }
            }
        }
    }
}

fn disc(gizmos: &mut Gizmos<SplineGizmos>, place: Isometry3d, radius: f32, color: Color) {
    gizmos.circle(place, radius, color).resolution(16);
}

/// The leg of a handle.
fn leg(anchors: &[Anchor], kind: ControlKind) -> Option<&GeodesicPath> {
    use crate::curve::HandleSide::{Incoming, Outgoing};
    match kind {
        ControlKind::Anchor(_) => None,
        ControlKind::Handle(i, Incoming) => anchors.get(i as usize).map(|a| a.incoming().leg()),
        ControlKind::Handle(i, Outgoing) => anchors.get(i as usize).map(|a| a.outgoing().leg()),
    }
}

fn world_positions(leg: &GeodesicPath, view: &SurfaceView) -> Vec<Vec3> {
    let positions = leg.positions(view.surface());
    positions.iter().map(|p| view.seen(p.as_vec3())).collect()
}

/// World length that covers one logical pixel at a position; none behind the eye.
fn world_per_pixel(camera: &Camera, eye: &GlobalTransform, position: Vec3) -> Option<f32> {
    let height = camera.logical_viewport_size()?.y;
    let clip_from_view = camera.clip_from_view();
    let view = eye.affine().inverse().transform_point3(position);
    let w = (clip_from_view * view.extend(1.0)).w;
    let pixel = 2.0 * w / (clip_from_view.y_axis.y * height);
    (pixel > 0.0 && pixel.is_finite()).then_some(pixel)
}
