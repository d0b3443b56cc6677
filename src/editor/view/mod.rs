//! What the viewport shows: curves and legs as lines, and the stage around the model.

pub(crate) mod draw;
pub(crate) mod drawn;
pub(crate) mod lines;
pub(crate) mod stage;
pub(crate) mod sticky;
