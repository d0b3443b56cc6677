//! How a control polygon becomes a curve, and how finely the curve is traced.

use crate::geodesic::PathQuality;

/// What curve a control polygon stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum Method {
    /// Recursive de Casteljau: polygons are halved by geodesic averages (Mancinelli et al. 2022, sec. 3.4).
    ///
    /// Interpolation: ends. Tangency: to the first and last leg. Continuity: C¹ inside.
    #[default]
    DeCasteljau,
    /// Open-uniform Lane–Riesenfeld: the polygon is subdivided as a B-spline of one interval (ibid., sec. 3.6).
    ///
    /// Interpolation: ends. Tangency: to the first and last leg. Continuity: C² inside, C¹ at the ends.
    LaneRiesenfeld,
    /// A uniform cubic B-spline: anchors are control points that the curve does not pass through, and handles do not count.
    ///
    /// Interpolation: the ends of an open spline. Continuity: C² across all segments. An open spline of m anchors has m − 3
    /// segments, a closed one m; with fewer than four (closed: three) there is no segment.
    BSpline,
    /// A uniform quadratic B-spline, likewise; open m − 2 segments, closed m. Continuity: C¹.
    QuadraticBSpline,
    /// De Casteljau's construction at every parameter by itself. **For comparison**: it jumps where a leg between
    /// intermediate points changes sides, which large polygons make it do.
    Direct,
    /// Centres of mass of the control points with Bernstein weights. **For comparison**: outside convex balls there are
    /// several, and it jumps between them; slow.
    CentreOfMass,
}

impl Method {
    /// All methods, those for comparison last.
    pub const ALL: [Self; 6] = [
        Self::DeCasteljau,
        Self::LaneRiesenfeld,
        Self::BSpline,
        Self::QuadraticBSpline,
        Self::Direct,
        Self::CentreOfMass,
    ];

    /// Its name for people.
    pub const fn name(self) -> &'static str {
        match self {
            Self::DeCasteljau => "Recursive de Casteljau",
            Self::LaneRiesenfeld => "Lane–Riesenfeld",
            Self::BSpline => "B-spline",
            Self::QuadraticBSpline => "Quadratic B-spline",
            Self::Direct => "Direct de Casteljau",
            Self::CentreOfMass => "Centre of mass",
        }
    }

    /// Whether anchors are control points of one long B-spline, so that handles do not count.
    pub const fn is_b_spline(self) -> bool {
        self.b_spline_degree().is_some()
    }

    /// The degree of a B-spline.
    pub(crate) const fn b_spline_degree(self) -> Option<usize> {
        match self {
            Self::BSpline => Some(3),
            Self::QuadraticBSpline => Some(2),
            _ => None,
        }
    }

    /// Whether it is there to be compared with, not to be used: it breaks on large polygons.
    pub const fn is_for_comparison(self) -> bool {
        matches!(self, Self::Direct | Self::CentreOfMass)
    }
}

/// How finely a curve is traced.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub enum Sampling {
    /// Every segment is halved this often, at most [`Scheme::MAX_LEVELS`]; those of schemes for comparison at most eight
    /// times.
    Levels(u8),
    /// Every segment is halved until no geodesic of its trace is longer than this, in local units, as far as its control
    /// polygon tells: exact in the plane, where the longest is mostly between a quarter of this and all of it.
    Length(f64),
    /// Each piece is halved until the trace is nearly straight there; schemes for comparison are traced with their usual
    /// number of points.
    ///
    /// Bounds: 20 halvings, 4,096 pieces a segment, pieces of 1e-10 of the surface's diagonal;
    /// [`SegmentTrace::bound`](super::SegmentTrace::bound) says if one was met before the trace was straight enough.
    Adaptive {
        /// Largest turn between consecutive geodesics of the trace, in radians.
        turn: f64,
        /// Longest geodesic, in local units; none: any.
        length: Option<f64>,
    },
}

/// How a control polygon becomes a trace: a method and its settings.
///
/// ```
/// use bevy_surface_splines::curve::Scheme;
///
/// let schemes = [
///     Scheme::lane_riesenfeld(),               // six levels, 67 points a segment
///     Scheme::de_casteljau().adaptive(),       // no turn above 5°
///     Scheme::b_spline().with_length(0.01),    // legs of a hundredth at most
///     Scheme::lane_riesenfeld().on_curve(),    // all points on the curve itself
/// ];
/// # let _ = schemes;
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bevy", derive(bevy_reflect::Reflect))]
#[cfg_attr(feature = "document", derive(serde::Serialize, serde::Deserialize))]
pub struct Scheme {
    /// What curve a polygon stands for.
    pub method: Method,
    /// How finely it is traced.
    pub sampling: Sampling,
    /// Whether all points of the trace lie on the curve; else it is a refined control polygon. Between the points it is then
    /// nearer to the curve: by a quarter with as many points of Lane–Riesenfeld, by two fifths with two thirds of the points
    /// of recursive de Casteljau.
    pub on_curve: bool,
    /// How hard the legs between control points, and between points made of them, are looked for.
    #[cfg_attr(feature = "document", serde(default))]
    pub quality: PathQuality,
}

impl Scheme {
    /// More levels than this are counted as this many: 2^12 pieces a segment.
    pub const MAX_LEVELS: u8 = 12;
    /// The largest turn that [`adaptive`](Self::adaptive) asks for: 5°.
    pub const TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;

    const fn new(method: Method, levels: u8) -> Self {
        Self { method, sampling: Sampling::Levels(levels), on_curve: false, quality: PathQuality::Default }
    }

    /// Recursive de Casteljau with four levels (48 legs).
    pub const fn de_casteljau() -> Self {
        Self::new(Method::DeCasteljau, 4)
    }

    /// Lane–Riesenfeld with six levels (67 points).
    pub const fn lane_riesenfeld() -> Self {
        Self::new(Method::LaneRiesenfeld, 6)
    }

    /// A cubic B-spline with four levels (48 legs a segment).
    pub const fn b_spline() -> Self {
        Self::new(Method::BSpline, 4)
    }

    /// A quadratic B-spline with four levels (32 legs a segment).
    pub const fn quadratic_b_spline() -> Self {
        Self::new(Method::QuadraticBSpline, 4)
    }

    /// Direct de Casteljau with 33 points; for comparison.
    pub const fn direct() -> Self {
        Self::new(Method::Direct, 5)
    }

    /// Centres of mass, 33 of them; for comparison.
    pub const fn centre_of_mass() -> Self {
        Self::new(Method::CentreOfMass, 5)
    }

    /// The default scheme of a method.
    pub const fn of(method: Method) -> Self {
        match method {
            Method::DeCasteljau => Self::de_casteljau(),
            Method::LaneRiesenfeld => Self::lane_riesenfeld(),
            Method::BSpline => Self::b_spline(),
            Method::QuadraticBSpline => Self::quadratic_b_spline(),
            Method::Direct => Self::direct(),
            Method::CentreOfMass => Self::centre_of_mass(),
        }
    }

    /// The same method with a number of levels.
    pub const fn with_levels(mut self, levels: u8) -> Self {
        self.sampling = Sampling::Levels(levels);
        self
    }

    /// The same method with legs no longer than a length, in local units.
    pub const fn with_length(mut self, length: f64) -> Self {
        self.sampling = Sampling::Length(length);
        self
    }

    /// The same method, traced so that it turns by at most 5° from geodesic to geodesic.
    pub const fn adaptive(mut self) -> Self {
        self.sampling = Sampling::Adaptive { turn: Self::TURN, length: None };
        self
    }

    /// The same method with all points of the trace on the curve.
    pub const fn on_curve(mut self) -> Self {
        self.on_curve = true;
        self
    }

    /// The same method with legs of a quality.
    pub const fn with_quality(mut self, quality: PathQuality) -> Self {
        self.quality = quality;
        self
    }
}

impl Scheme {
    /// Whether its numbers are numbers.
    pub(crate) fn is_sound(self) -> bool {
        match self.sampling {
            Sampling::Levels(_) => true,
            Sampling::Length(length) => !length.is_nan(),
            Sampling::Adaptive { turn, length } => !turn.is_nan() && !length.is_some_and(f64::is_nan),
        }
    }

    /// The same scheme with zeros instead of what is no number, which equals nothing, not even itself.
    pub(crate) fn settled(self) -> Self {
        let number = |x: f64| if x.is_nan() { 0.0 } else { x };
        let sampling = match self.sampling {
            Sampling::Levels(levels) => Sampling::Levels(levels.min(Self::MAX_LEVELS)),
            Sampling::Length(length) => Sampling::Length(number(length)),
            Sampling::Adaptive { turn, length } => {
                Sampling::Adaptive { turn: number(turn), length: length.map(number) }
            }
        };
        Self { sampling, ..self }
    }
}

impl Default for Scheme {
    fn default() -> Self {
        Self::de_casteljau()
    }
}

impl Sampling {
    /// Levels for a polygon whose longest leg is given; none where the sampling is adaptive.
    pub(crate) fn levels(self, longest: f64) -> Option<u8> {
        match self {
            Self::Levels(levels) => Some(levels.min(Scheme::MAX_LEVELS)),
            Self::Length(length) => {
                let halvings = (longest / length.max(f64::MIN_POSITIVE)).log2().ceil();
                // A cast saturates, and makes zero of NaN.
                Some((halvings.max(0.0) as u8).min(Scheme::MAX_LEVELS))
            }
            Self::Adaptive { .. } => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_become_levels() {
        let levels = |length: f64, longest: f64| Sampling::Length(length).levels(longest).unwrap();
        assert_eq!([levels(1.0, 0.5), levels(1.0, 1.0), levels(1.0, 1.1), levels(0.1, 1.0)], [0, 0, 1, 4]);
        assert_eq!([levels(0.0, 1.0), levels(f64::NAN, 1.0), levels(1.0, 0.0), levels(-1.0, 1.0)], [12, 12, 0, 12]);
        assert_eq!(Sampling::Levels(200).levels(1.0), Some(12));
        assert_eq!(Scheme::de_casteljau().adaptive().sampling.levels(1.0), None);
    }

    #[test]
    fn what_is_no_number_is_zero() {
        let odd =
            Scheme { sampling: Sampling::Adaptive { turn: f64::NAN, length: Some(f64::NAN) }, ..Scheme::default() };
        assert!(!odd.is_sound() && odd.settled().is_sound() && odd.settled() == odd.settled());
        assert!(!Scheme::b_spline().with_length(f64::NAN).is_sound());
        assert_eq!(Scheme::direct().with_levels(200).settled(), Scheme::direct().with_levels(12));
    }

    #[test]
    fn methods_have_names_of_their_own() {
        for (i, a) in Method::ALL.iter().enumerate() {
            assert!(Method::ALL[i + 1..].iter().all(|b| a.name() != b.name() && a != b));
            assert_eq!(Scheme::of(*a).method, *a);
        }
    }
}
