//! Schemes that break on large control polygons, to compare with: direct de Casteljau and centres of mass.
//!
//! Both place every point by searched paths, whose ends move smoothly while the shortest path between them jumps from one
//! side of an obstacle to the other. Such jumps are looked for and reported.

use glam::DVec2;

use super::{
    Jump, Method, Sampling, TraceError,
    average::Averager,
    casteljau::{Legs, Split},
    piece::{Spot, spot},
    sample::Sampled,
};
use crate::geodesic::{
    PathError,
    inner::InnerPath,
    tangent::{InnerTangent, spell_in, turn_at},
    transport::{angle_at, initial_direction, transport},
    walk::walk,
};
use crate::surface::InnerPoint;

/// Levels of these schemes where the sampling is adaptive.
const LEVELS: u8 = 5;
/// Most levels: centres of mass take milliseconds each where legs are long.
const MOST_LEVELS: u8 = 8;

/// Traces a segment by points at evenly spaced parameters, and finds where they jump.
///
/// Between two points that are further apart than their neighbours are, or than the control polygon allows in the plane, the
/// parameters are bisected ten times; what is still a thirtieth as far apart, instead of a thousandth, is a jump.
pub(crate) fn sample(
    averager: &mut Averager<'_>,
    legs: &[InnerPath],
    method: Method,
    sampling: Sampling,
) -> Result<(Sampled, Vec<Jump>), TraceError> {
    /// Steps longer than both neighbours by this factor are looked at.
    const LONGER: f64 = 1.25;
    let longest = legs.iter().map(|leg| leg.length).fold(0.0, f64::max);
    let count = 1_usize << sampling.levels(longest).unwrap_or(LEVELS).min(MOST_LEVELS);
    let parameters: Vec<f64> = (0..=count).map(|k| k as f64 / count as f64).collect();
    let mut points = Vec::with_capacity(count + 1);
    let mut paths: Vec<InnerPath> = Vec::with_capacity(count);
    let mut here = start(legs);
    points.push(here);
    for t in &parameters[1..] {
        let next = point_at(averager, legs, method, *t, &here)?;
        paths.push(averager.leg(&here, &next)?);
        points.push(next);
        here = next;
    }
    let reach = legs.len() as f64 * longest / count as f64;
    let step = |i: Option<usize>| i.and_then(|i| paths.get(i)).map_or(0.0, |path| path.length);
    let mut jumps = Vec::new();
    for (i, path) in paths.iter().enumerate() {
        let around = step(i.checked_sub(1)).max(step(Some(i + 1)));
        if path.length > (LONGER * around).min(reach * (1.0 + 1e-9)) {
            let ends = [(parameters[i], points[i]), (parameters[i + 1], points[i + 1])];
            jumps.extend(jump_between(averager, legs, method, ends, path.length)?);
        }
    }
    Ok((Sampled { paths, parameters, bound: None }, jumps))
}

/// Bisects between two points a step apart, towards the larger gap.
fn jump_between(
    averager: &mut Averager<'_>,
    legs: &[InnerPath],
    method: Method,
    [mut low, mut high]: [(f64, InnerPoint); 2],
    step: f64,
) -> Result<Option<Jump>, PathError> {
    const BISECTIONS: u32 = 10;
    const LEFT: f64 = 1.0 / 30.0;
    let mut gap = step;
    for _ in 0..BISECTIONS {
        let t = 0.5 * (low.0 + high.0);
        let middle = point_at(averager, legs, method, t, &low.1)?;
        let halves = [averager.leg(&low.1, &middle)?.length, averager.leg(&middle, &high.1)?.length];
        if halves[0] >= halves[1] {
            (high, gap) = ((t, middle), halves[0]);
        } else {
            (low, gap) = ((t, middle), halves[1]);
        }
    }
    Ok((gap > LEFT * step).then_some(Jump { t: 0.5 * (low.0 + high.0), length: gap }))
}

/// The point at a parameter, with its derivatives.
pub(crate) fn evaluate(
    averager: &mut Averager<'_>,
    legs: &[InnerPath],
    method: Method,
    t: f64,
) -> Result<Spot, PathError> {
    if method == Method::Direct {
        let split = direct(averager, legs, t)?;
        return Ok(spot(averager, &split, t));
    }
    differences(averager, legs, t.clamp(0.0, 1.0))
}

fn start(legs: &[InnerPath]) -> InnerPoint {
    legs.first().map_or_else(InnerPoint::default, |leg| leg.start)
}

/// The point at a parameter; `near` is where the search for a centre of mass begins.
fn point_at(
    averager: &mut Averager<'_>,
    legs: &[InnerPath],
    method: Method,
    t: f64,
    near: &InnerPoint,
) -> Result<InnerPoint, PathError> {
    if method == Method::CentreOfMass {
        return centre_of_mass(averager, legs, t, near);
    }
    let split = direct(averager, legs, t)?;
    Ok(split.left.last().map_or_else(InnerPoint::default, |leg| leg.end))
}

/// De Casteljau's construction at `t`, every leg searched.
fn direct(averager: &mut Averager<'_>, legs: &[InnerPath], t: f64) -> Result<Split, PathError> {
    let surface = averager.surface;
    let mut round: Legs = legs.to_vec();
    let (mut left, mut right) = (Legs::new(), Legs::new());
    loop {
        left.extend(round.first().map(|leg| leg.piece(surface, 0.0, t)));
        right.extend(round.last().map(|leg| leg.piece(surface, t, 1.0)));
        if round.len() <= 1 {
            break;
        }
        let points: Vec<InnerPoint> = round.iter().map(|leg| averager.point(leg, t)).collect();
        round = points.windows(2).map(|pair| averager.leg(&pair[0], &pair[1])).collect::<Result<_, _>>()?;
    }
    right.reverse();
    Ok(Split { left, right })
}

/// The point with the least mean square distance from the control points, weighted by Bernstein's polynomials: steps along
/// the mean of the logarithms, from a point near it (Karcher 1977).
fn centre_of_mass(
    averager: &mut Averager<'_>,
    legs: &[InnerPath],
    t: f64,
    near: &InnerPoint,
) -> Result<InnerPoint, PathError> {
    const STEPS: u32 = 64;
    const STILL: f64 = 1e-8;
    let still = STILL * averager.surface.diagonal();
    let points: Vec<InnerPoint> = legs.iter().map(|leg| leg.start).chain(legs.last().map(|leg| leg.end)).collect();
    let weights = bernstein(legs.len(), t);
    if let Some(only) = weights.iter().position(|w| *w == 1.0) {
        return Ok(points[only]); // steps may get stuck behind a vertex at which the path there bends
    }
    let mut here = *near;
    let (mut direction, mut energy) = mean_logarithm(averager, &here, &points, &weights)?;
    let mut share = 1.0;
    for _ in 0..STEPS {
        let step = share * direction.vector.length();
        if step < still {
            break;
        }
        let to = walk(averager.surface, &here, &direction, step).path.end;
        let (next_direction, next_energy) = mean_logarithm(averager, &to, &points, &weights)?;
        if next_energy > energy {
            share *= 0.5;
        } else {
            (here, direction, energy) = (to, next_direction, next_energy);
        }
    }
    Ok(here)
}

/// Weights of a Bézier polygon's points.
fn bernstein(degree: usize, t: f64) -> Vec<f64> {
    let s = 1.0 - t;
    if degree == 2 {
        vec![s * s, 2.0 * s * t, t * t]
    } else {
        vec![s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
    }
}

/// The mean of the directions and distances to some points, and half the mean square distance.
fn mean_logarithm(
    averager: &mut Averager<'_>,
    here: &InnerPoint,
    points: &[InnerPoint],
    weights: &[f64],
) -> Result<(InnerTangent, f64), PathError> {
    let surface = averager.surface;
    // Vectors are summed in a frame whose x axis is the first direction found.
    let mut axis: Option<InnerTangent> = None;
    let (mut sum, mut energy) = (DVec2::ZERO, 0.0);
    for (point, weight) in points.iter().zip(weights).filter(|(_, weight)| **weight > 0.0) {
        let path = averager.leg(here, point)?;
        energy += 0.5 * weight * path.length * path.length;
        let direction = initial_direction(surface, &path);
        if direction.vector == DVec2::ZERO {
            continue;
        }
        let axis = axis.get_or_insert(direction);
        let at = spell_in(surface, here, axis.face).unwrap_or(*here);
        sum += DVec2::from_angle(angle_at(surface, &at, axis, &direction)) * (weight * path.length);
    }
    let nothing = InnerTangent { face: here.face, vector: DVec2::ZERO };
    let Some(axis) = axis else { return Ok((nothing, energy)) };
    let at = spell_in(surface, here, axis.face).unwrap_or(*here);
    let turned = turn_at(surface, &at, &axis, sum.y.atan2(sum.x));
    Ok((InnerTangent { face: turned.face, vector: turned.vector * sum.length() }, energy))
}

/// A centre of mass with derivatives by central differences, of a thousandth of the parameter.
fn differences(averager: &mut Averager<'_>, legs: &[InnerPath], t: f64) -> Result<Spot, PathError> {
    const STEP: f64 = 1e-3;
    let surface = averager.surface;
    let weights = bernstein(legs.len(), t);
    let heaviest = (0..weights.len()).fold(0, |best, i| if weights[i] > weights[best] { i } else { best });
    let near = legs.get(heaviest).map_or_else(|| legs.last().map(|leg| leg.end), |leg| Some(leg.start));
    let point = centre_of_mass(averager, legs, t, &near.unwrap_or_default())?;
    let middle = t.clamp(STEP, 1.0 - STEP);
    let centre = if middle == t { point } else { centre_of_mass(averager, legs, middle, &point)? };
    let [before, after] = [middle - STEP, middle + STEP].map(|t| {
        let end = centre_of_mass(averager, legs, t, &centre)?;
        averager.leg(&centre, &end)
    });
    let (before, after) = (before?, after?);
    let [u, v] = [&before, &after].map(|path| initial_direction(surface, path));
    if u.vector == DVec2::ZERO || v.vector == DVec2::ZERO {
        let derivative = InnerTangent { face: point.face, vector: DVec2::ZERO };
        return Ok(Spot { point, derivative, curvature: 0.0 });
    }
    let at = spell_in(surface, &centre, v.face).unwrap_or(centre);
    let forward = DVec2::X * after.length;
    let backward = DVec2::from_angle(angle_at(surface, &at, &v, &u)) * before.length;
    let velocity = (forward - backward) / (2.0 * STEP);
    let acceleration = (forward + backward) / (STEP * STEP);
    let turned = turn_at(surface, &at, &v, velocity.y.atan2(velocity.x));
    let derivative = InnerTangent { face: turned.face, vector: turned.vector * velocity.length() };
    // At the ends it is that of a place nearby.
    let derivative = if middle == t {
        derivative
    } else {
        let way = averager.leg(&centre, &point)?;
        transport(surface, &way, &derivative)
    };
    let point = spell_in(surface, &point, derivative.face).unwrap_or(point);
    Ok(Spot { point, derivative, curvature: velocity.perp_dot(acceleration) / velocity.length().powi(3) })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::curve::{Scheme, Tracer};
    use crate::surface::{Surface, SurfaceOptions, shapes};

    #[test]
    fn curves_end_at_the_last_control_point_whatever_lies_between() {
        let mut mesh = shapes::grid(4, 4, 4.0, 4.0);
        let inside = |p: DVec3| (1.0..=3.0).contains(&p.x) && (1.0..=3.0).contains(&p.y);
        mesh.faces.retain(|t| !t.iter().all(|v| inside(mesh.positions[*v as usize])));
        let surface = Surface::build(&mesh, &SurfaceOptions::default()).unwrap();
        let polygon = [(0.2, 1.7), (0.3, 1.2), (3.4, 2.9), (3.7, 2.1)]
            .map(|(x, y)| surface.closest_point(DVec3::new(x, y, 0.0)).unwrap().point);
        for scheme in [Scheme::direct(), Scheme::centre_of_mass()].map(|scheme| scheme.with_levels(2)) {
            let trace = Tracer::new(&surface).trace(&polygon, &scheme).unwrap();
            let points = trace.segments()[0].points();
            assert!(surface.same_place(&points[0], &polygon[0]) && surface.same_place(&points[4], &polygon[3]));
        }
    }
}
