//! By what lines are smoothed.

use bevy_surface_splines::smooth::{Smoothing, SmoothingMode};

/// A mode with its number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting {
    pub(crate) number: f64,
    pub(crate) smoothing: Smoothing,
}

impl Setting {
    pub(crate) fn name(&self) -> &'static str {
        match self.smoothing.mode {
            SmoothingMode::Budget { .. } => "plain",
            mode => mode.name(),
        }
    }
}

/// The setting of a mode, or all that are compared.
pub(crate) fn of_mode(mode: &str) -> Vec<Setting> {
    let by = |number: f64, mode: SmoothingMode| Setting { number, smoothing: Smoothing::by(mode) };
    let budget = |share: f64| by(share, SmoothingMode::Budget { share });
    let stencil = |scale: f64| by(scale, SmoothingMode::Stencil { scale, passes: 5 });
    let tether = |closeness: f64| by(closeness, SmoothingMode::Tether { closeness });
    let lift = |weight: f64| by(weight, SmoothingMode::Lift { weight });
    let conformal = |weight: f64| by(weight, SmoothingMode::Conformal { weight });
    match mode {
        "geodesic" => vec![by(0.0, SmoothingMode::Geodesic)],
        "stencil" => vec![stencil(1.0)],
        "budget" => vec![budget(0.25)],
        "lift" => vec![lift(1.0)],
        "conformal" => vec![conformal(10.0)],
        "tradeoff" => {
            let mut all = Vec::new();
            all.extend([0.8, 0.6, 0.4, 0.2, 0.1].map(budget));
            all.extend([1.0, 0.75, 0.5, 0.25, 0.1].map(stencil));
            all.extend([0.1, 1.0, 10.0, 100.0, 1000.0].map(tether));
            all.extend([0.1, 1.0, 10.0, 100.0, 1000.0].map(lift));
            all.extend([0.1, 1.0, 10.0, 100.0, 1000.0].map(conformal));
            all
        }
        _ => vec![tether(10.0)],
    }
}
