//! What does a frame with characters cost? Whole headless apps (animation, joints, skins, tessellation, everything but rendering) with a made figure of
//! 400 curves: one in the plane, a hundred at different phases, and one that walks on a torus of 100,000 faces. Wall time of `App::update`, the median
//! and the 99th percentile of frames, beside the same app while nothing moves, and how often memory is taken: in all, and more than while nothing moves.
//!
//! The engine's pool for computing has a thread for each core: left to itself, it has one of two, and keeps the other for waiting.

mod common;

use std::alloc::System;
use std::time::Duration;

use bevy::animation::graph::AnimationGraph;
use bevy::ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use bevy::prelude::*;
use bevy::tasks::{ComputeTaskPool, TaskPoolBuilder};
use bevy::time::TimeUpdateStrategy;
use bevy_surface_splines::plugin::testing::{unfinished_headless_app, update_until};
use bevy_surface_splines::plugin::{BezierCharacter, CharacterAsset, CharacterState, PathStatistics, mesh_from};
use bevy_surface_splines::prelude::*;
use common::{arguments::Arguments, clock, figure::figure, made, table, table::Table};
use glam::DVec3;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static MEMORY: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// A frame of 60 a second.
const FRAME: Duration = Duration::from_micros(16_667);

fn app(on_one_thread: bool) -> App {
    let mut app = unfinished_headless_app();
    app.add_plugins(SurfaceSplinePlugins).insert_resource(TimeUpdateStrategy::ManualDuration(FRAME));
    if on_one_thread {
        for label in [First.intern(), PreUpdate.intern(), Update.intern(), PostUpdate.intern(), Last.intern()] {
            app.edit_schedule(label, |schedule| {
                schedule.set_executor(SingleThreadedExecutor::new());
            });
        }
    }
    app.finish();
    app.cleanup();
    app
}

/// Characters that play the clip at different phases.
fn spawn(app: &mut App, count: usize, bundle: impl Fn() -> Option<(OnSurface, Placement)>) -> Vec<Entity> {
    let character = figure().unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(character.drawing.segment_count(), 400);
    let made = app.world_mut().resource_scope(|world, mut clips: Mut<Assets<AnimationClip>>| {
        CharacterAsset::new(character, &mut clips, &mut world.resource_mut::<Assets<AnimationGraph>>())
    });
    let node = made.node("walk").unwrap_or_else(|| panic!("there is a clip"));
    let handle = app.world_mut().resource_mut::<Assets<CharacterAsset>>().add(made);
    let mut all = Vec::new();
    for _ in 0..count {
        let mut one = app.world_mut().spawn(BezierCharacter(handle.clone()));
        if let Some(placed) = bundle() {
            one.insert(placed);
        }
        all.push(one.id());
    }
    let is_ready =
        |world: &mut World| all.iter().all(|one| world.get::<CharacterState>(*one) == Some(&CharacterState::Ready));
    assert!(update_until(app, is_ready), "the characters are there");
    for (number, one) in all.iter().enumerate() {
        let mut player =
            app.world_mut().get_mut::<AnimationPlayer>(*one).unwrap_or_else(|| panic!("there is a player"));
        player.play(node).repeat().seek_to(number as f32 / count as f32);
    }
    all
}

/// Times of frames in milliseconds, and allocations of each.
fn frames(app: &mut App, count: usize, mut before: impl FnMut(&mut App)) -> (Vec<f64>, f64) {
    let (mut times, mut taken) = (Vec::with_capacity(count), 0);
    for _ in 0..count {
        before(app);
        let region = Region::new(MEMORY);
        let (ms, ()) = clock::wall_ms(|| app.update());
        let change = region.change();
        taken += change.allocations + change.reallocations;
        times.push(ms);
    }
    times.sort_by(f64::total_cmp);
    (times, taken as f64 / count as f64)
}

fn main() {
    let arguments = Arguments::read();
    let count = if arguments.quick { 20 } else { 1000 };
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(bevy::tasks::available_parallelism()).build());
    println!("A figure of 400 curves with 13 joints, a fill and a stroke on every shape; {count} frames of 1/60 s.");
    let table = Table::new(&[
        "scene",
        "threads",
        "median ms",
        "99th percentile ms",
        "worst ms",
        "median at rest ms",
        "of it tessellating ms",
        "fills kept",
        "fills anew",
        "allocations a frame",
        "of it by moving",
    ]);
    for (scene, many) in [("one in the plane", 1), ("a hundred in the plane", 100), ("one walking on a torus", 0)] {
        for on_one_thread in [true, false] {
            let mut app = app(on_one_thread);
            let torus = (many == 0).then(|| {
                let faces = if arguments.quick { 10_000 } else { 100_000 };
                let mesh = mesh_from(&made::rippled_torus(faces));
                let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
                let torus = app.world_mut().spawn((Mesh3d(mesh), SplineSurface::default())).id();
                let is_built = |world: &mut World| world.get::<BuiltSurface>(torus).is_some();
                assert!(update_until(&mut app, is_built), "the surface is built");
                torus
            });
            let surface = torus.and_then(|torus| app.world().get::<BuiltSurface>(torus).cloned());
            let place = surface.as_ref().zip(torus).and_then(|(surface, torus)| {
                let at = surface.closest_point(DVec3::new(0.0, surface.diagonal(), 0.0))?.point;
                Some((OnSurface(torus), Placement { at, up: Vec3::Z, scale: surface.diagonal() / 2000.0 }))
            });
            let all = spawn(&mut app, many.max(1), || place);
            let walk = |app: &mut App| {
                if let Some(surface) = &surface
                    && let Some(mut place) = app.world_mut().get_mut::<Placement>(all[0])
                {
                    let step = 0.001 * surface.diagonal();
                    place.walk(surface, 1.0, step).unwrap_or_else(|error| panic!("{error}"));
                }
            };
            frames(&mut app, 120.min(count), walk);
            let (mut kept, mut anew, mut tessellating) = (0, 0, 0.0);
            let (times, taken) = frames(&mut app, count, |app| {
                let statistics = app.world().resource::<PathStatistics>();
                kept += statistics.made.kept;
                anew += statistics.made.filled;
                tessellating += statistics.milliseconds;
                walk(app);
            });
            for one in &all {
                if let Some(mut player) = app.world_mut().get_mut::<AnimationPlayer>(*one) {
                    player.pause_all();
                }
            }
            frames(&mut app, 10, |_| ());
            let (rest, still) = frames(&mut app, count.min(100), |_| ());
            let at = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize];
            let mean = |sum: f64| table::number(Some(sum / count as f64));
            table.row([
                scene.to_owned(),
                if on_one_thread { "one for systems".to_owned() } else { "all".to_owned() },
                table::number(Some(at(0.5))),
                table::number(Some(at(0.99))),
                table::number(Some(at(1.0))),
                table::number(rest.get(rest.len() / 2).copied()),
                mean(tessellating),
                mean(f64::from(kept)),
                mean(f64::from(anew)),
                format!("{taken:.1}"),
                format!("{:.1}", taken - still),
            ]);
        }
    }
}
