//! Rests where nothing happens: a picture that does not change need not be drawn sixty times a second.

use std::time::Duration;

use bevy::prelude::*;
use bevy::window::WindowEvent;
use bevy::winit::{UpdateMode, WinitSettings};
use bevy_surface_splines::editor::{DocumentFile, History};

use crate::arguments::Arguments;

/// So long after the last that happened every frame is drawn: what it set off may take a while to show.
const LINGER: Duration = Duration::from_secs(1);
/// The time between frames at rest, in which what ends by itself is seen soon enough.
const REST: Duration = Duration::from_millis(100);

pub(crate) fn plugin(app: &mut App) {
    app.insert_resource(WinitSettings::continuous())
        .add_systems(Last, rest.run_if(|arguments: Res<Arguments>| !arguments.is_scripted()));
}

fn rest(
    mut settings: ResMut<WinitSettings>,
    mut events: MessageReader<WindowEvent>,
    mut quiet: Local<Duration>,
    time: Res<Time<Real>>,
    (files, history): (Res<DocumentFile>, Res<History>),
) {
    let is_busy = files.working().is_some() || history.is_busy();
    *quiet = if events.read().count() > 0 || is_busy { Duration::ZERO } else { *quiet + time.delta() };
    // In long frames a second is over before anything could show.
    let mode = if *quiet > LINGER.max(4 * time.delta()) { UpdateMode::reactive(REST) } else { UpdateMode::Continuous };
    if settings.focused_mode != mode {
        *settings = WinitSettings { focused_mode: mode, unfocused_mode: mode };
    }
}
