//! How long does a pose of a character take, from its clip to its triangles? A made figure of 400 curves with a fill and a stroke on every
//! shape: joints are sampled, control points solved, shapes tessellated again; then laid onto a torus of 100,000 faces, along which it walks.
//!
//! Wall time of a frame of one figure on one thread, in frames of 1/60 s, and the mean time of a figure of a hundred at different phases. Allocations
//! are counted by a published allocator.

mod common;

use std::alloc::System;

use bevy_surface_splines::{
    character::{BindProgress, BoundCharacter, Character},
    placement::{Placement, PlaneMap, PlaneWalk},
    skin::Posed,
    surface::{Surface, SurfaceOptions},
    vector::{Picture, PictureChange, PictureMesh, PictureOptions, PicturePoints, Tessellator},
};
use common::{arguments::Arguments, clock, figure::figure, made, table, table::Table};
use glam::{DAffine2, DVec2, DVec3};
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};

#[global_allocator]
static MEMORY: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// A figure in some pose.
struct Figure<'a> {
    character: &'a Character,
    bound: &'a BoundCharacter,
    picture: &'a Picture,
    locals: Vec<bevy_surface_splines::character::JointPose>,
    worlds: Vec<DAffine2>,
    posed: Posed,
    points: PicturePoints,
    mesh: PictureMesh,
}

impl<'a> Figure<'a> {
    fn new(character: &'a Character, bound: &'a BoundCharacter, picture: &'a Picture) -> Self {
        let (locals, worlds) = (character.rest_poses(), Vec::new());
        let (posed, points, mesh) = (bound.skin.at_rest(), picture.points(), PictureMesh::default());
        Self { character, bound, picture, locals, worlds, posed, points, mesh }
    }

    fn pose(&mut self, time: f64) {
        self.character.sample(0, time, &mut self.locals);
        self.character.worlds(&self.locals, &mut self.worlds);
        self.bound.pose(&self.worlds, &mut self.posed).unwrap_or_else(|error| panic!("{error}"));
        for (number, path) in self.bound.paths.iter().enumerate() {
            self.points.set(number, self.bound.skin.points(&self.posed, path.chain));
        }
    }

    fn tessellate(&mut self, tessellator: &mut Tessellator) -> PictureChange {
        self.mesh.update(self.picture, &self.points, tessellator)
    }
}

fn main() {
    let arguments = Arguments::read();
    let (frames, faces) = if arguments.quick { (60, 10_000) } else { (1200, 100_000) };
    let character = figure().unwrap_or_else(|error| panic!("{error}"));
    let bound = character.bind(&BindProgress::default()).unwrap_or_else(|error| panic!("{error}"));
    let shapes = || {
        let shape = |path: &bevy_surface_splines::character::CharacterPath| &character.drawing.shapes[path.shape];
        bound.paths.iter().map(move |path| (&shape(path).paths[..], &shape(path).style))
    };
    let options = PictureOptions { origin: Some(character.drawing.centre()), ..PictureOptions::default() };
    let plane = Picture::planar(shapes(), &[], &options);
    let spaced = PictureOptions { spacing: Some(plane.extent() / 40.0), ..options };
    let spaced = Picture::planar(shapes(), &[], &spaced);
    println!("{} curves, {} joints, {frames} frames.\n", plane.segment_count(), character.joints.len());

    let table = Table::new(&[
        "step",
        "median ms",
        "99th percentile ms",
        "worst ms",
        "vertices",
        "fills kept",
        "fills anew",
        "allocations",
    ]);
    let surface = Surface::build(&made::rippled_torus(faces), &SurfaceOptions::default());
    let surface = surface.unwrap_or_else(|error| panic!("{error}"));
    for (name, picture) in [("in the plane", &plane), ("for a surface", &spaced)] {
        let mut one = Figure::new(&character, &bound, picture);
        let mut tessellator = Tessellator::default();
        let at = surface.closest_point(DVec3::new(0.0, surface.diagonal(), 0.0)).map(|found| found.point);
        let at = at.unwrap_or_else(|| panic!("there is a place"));
        let mut place = Placement { at, up: DVec3::Z, scale: surface.diagonal() / 2000.0 };
        let mut walk = PlaneWalk::default();
        let (mut posing, mut making, mut laying) = (Vec::new(), Vec::new(), Vec::new());
        let (mut kept, mut anew, mut taken) = (0, 0, 0);
        for frame in 0..frames + 120 {
            let time = f64::from(frame) / 60.0;
            let region = Region::new(MEMORY);
            let (ms, ()) = clock::wall_ms(|| one.pose(time));
            let (made_ms, change) = clock::wall_ms(|| one.tessellate(&mut tessellator));
            let took = region.change();
            // Two rounds of the clip to warm up.
            if frame < 120 {
                continue;
            }
            taken += took.allocations + took.reallocations;
            (kept, anew) = (kept + change.kept, anew + change.filled);
            posing.push(ms);
            making.push(made_ms);
            if std::ptr::eq(picture, &spaced) {
                let walked = place.walked(&surface, 1.0, 0.001 * surface.diagonal());
                place = walked.unwrap_or_else(|error| panic!("{error}")).placement;
                let (ms, off) = clock::wall_ms(|| lay(&surface, &place, &one, &mut walk));
                assert_eq!(off, 0, "a torus has no boundary");
                laying.push(ms);
            }
        }
        let row = |step: String, times: &mut Vec<f64>, counts: [String; 3]| {
            if times.is_empty() {
                return;
            }
            times.sort_by(f64::total_cmp);
            let at = |share: f64| table::number(Some(times[((times.len() - 1) as f64 * share).round() as usize]));
            let vertices = one.mesh.positions.len().to_string();
            let [kept, anew, taken] = counts;
            table.row([step, at(0.5), at(0.99), at(1.0), vertices, kept, anew, taken]);
        };
        let mean = |count: u32| table::number(Some(f64::from(count) / f64::from(frames)));
        let none = || [String::new(), String::new(), String::new()];
        row(format!("pose, {name}"), &mut posing, none());
        let taken = table::number(Some(taken as f64 / f64::from(frames)));
        row(format!("triangles, {name}"), &mut making, [mean(kept), mean(anew), taken]);
        row("ways to all vertices on the surface, one thread".to_owned(), &mut laying, none());
    }
    let mut all: Vec<Figure<'_>> = (0..100).map(|_| Figure::new(&character, &bound, &plane)).collect();
    let mut tessellator = Tessellator::default();
    let mut round = |time: f64| {
        for (number, one) in all.iter_mut().enumerate() {
            one.pose(time + number as f64 / 100.0);
            one.tessellate(&mut tessellator);
        }
    };
    (0..60).for_each(|frame| round(f64::from(frame) / 60.0));
    let frames = if arguments.quick { 2 } else { 120 };
    let mut times: Vec<f64> = (0..frames).map(|frame| clock::wall_ms(|| round(f64::from(frame) / 60.0)).0).collect();
    times.sort_by(f64::total_cmp);
    let at = |share: f64| times[((times.len() - 1) as f64 * share).round() as usize];
    println!(
        "\nA hundred in the plane, one after the other: {:.2} ms, at the 99th percentile {:.2} ms.",
        at(0.5),
        at(0.99)
    );
}

/// Lays all vertices onto the surface; how many are off it.
fn lay(surface: &Surface, place: &Placement, figure: &Figure<'_>, walk: &mut PlaneWalk) -> usize {
    let map = PlaneMap::new(surface, place, figure.picture.origin()).unwrap_or_else(|error| panic!("{error}"));
    let all = figure.mesh.positions.iter();
    all.filter(|p| map.place(DVec2::new(f64::from(p[0]), f64::from(p[1])), walk).is_off).count()
}
