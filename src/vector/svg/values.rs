//! Values of attributes: lengths, transforms, viewports.

use std::str::FromStr;

use glam::{DAffine2, DMat2, DVec2};
use roxmltree::Node;
use svgtypes::{Align, AspectRatio, Length, LengthUnit};

use super::report::LeftOutReason;
use crate::vector::ViewBox;

/// What a percentage is of.
#[derive(Clone, Copy)]
pub(super) enum Of {
    Width,
    Height,
    Diagonal,
}

/// What lengths depend on.
#[derive(Clone, Copy)]
pub(super) struct Units {
    /// Width and height of the nearest viewport.
    pub(super) viewport: DVec2,
    pub(super) font_size: f64,
}

impl Units {
    pub(super) fn length(&self, length: Length, of: Of) -> f64 {
        let factor = match length.unit {
            LengthUnit::None | LengthUnit::Px => 1.0,
            LengthUnit::Em => self.font_size,
            LengthUnit::Ex => 0.5 * self.font_size,
            LengthUnit::In => 96.0,
            LengthUnit::Cm => 96.0 / 2.54,
            LengthUnit::Mm => 9.6 / 2.54,
            LengthUnit::Pt => 4.0 / 3.0,
            LengthUnit::Pc => 16.0,
            LengthUnit::Percent => {
                let DVec2 { x, y } = self.viewport;
                0.01 * match of {
                    Of::Width => x,
                    Of::Height => y,
                    Of::Diagonal => (0.5 * (x * x + y * y)).sqrt(),
                }
            }
        };
        length.number * factor
    }

    /// A length attribute; none where it is missing, empty or `auto`.
    pub(super) fn attribute(
        &self,
        node: &Node<'_, '_>,
        name: &'static str,
        of: Of,
    ) -> Result<Option<f64>, LeftOutReason> {
        let Some(text) = node.attribute(name).map(str::trim).filter(|text| !text.is_empty() && *text != "auto") else {
            return Ok(None);
        };
        let length = Length::from_str(text).map_err(|_| LeftOutReason::BadAttribute(name))?;
        Some(self.length(length, of)).filter(|l| l.is_finite()).map(Some).ok_or(LeftOutReason::BadAttribute(name))
    }
}

/// The transform that a text says.
pub(super) fn transform(text: &str, name: &'static str) -> Result<DAffine2, LeftOutReason> {
    let t = svgtypes::Transform::from_str(text).map_err(|_| LeftOutReason::BadAttribute(name))?;
    let matrix = DMat2::from_cols(DVec2::new(t.a, t.b), DVec2::new(t.c, t.d));
    Ok(DAffine2::from_mat2_translation(matrix, DVec2::new(t.e, t.f)))
}

/// Whether a transform has an inverse that can be trusted.
pub(super) fn is_regular(transform: &DAffine2) -> bool {
    let DMat2 { x_axis, y_axis } = transform.matrix2;
    let area = x_axis.perp_dot(y_axis).abs();
    transform.is_finite() && area > 1e-12 * x_axis.length() * y_axis.length() && area > 0.0
}

/// The view box of an element, if it has one of some size.
pub(super) fn view_box(node: &Node<'_, '_>) -> Option<ViewBox> {
    let found = svgtypes::ViewBox::from_str(node.attribute("viewBox")?).ok()?;
    let sound = [found.x, found.y, found.w, found.h].iter().all(|v| v.is_finite()) && found.w > 0.0 && found.h > 0.0;
    sound.then_some(ViewBox { min: DVec2::new(found.x, found.y), size: DVec2::new(found.w, found.h) })
}

/// The map that shows a view box in a viewport at the origin, as `preserveAspectRatio` says.
pub(super) fn fit(node: &Node<'_, '_>, view: &ViewBox, size: DVec2) -> DAffine2 {
    let said = node.attribute("preserveAspectRatio").and_then(|text| AspectRatio::from_str(text).ok());
    let (align, slice) = said.map_or((Align::XMidYMid, false), |said| (said.align, said.slice));
    let mut scale = size / view.size;
    if align != Align::None {
        let one = if slice { scale.max_element() } else { scale.min_element() };
        scale = DVec2::splat(one);
    }
    let (x, y) = match align {
        Align::None | Align::XMinYMin => (0.0, 0.0),
        Align::XMidYMin => (0.5, 0.0),
        Align::XMaxYMin => (1.0, 0.0),
        Align::XMinYMid => (0.0, 0.5),
        Align::XMidYMid => (0.5, 0.5),
        Align::XMaxYMid => (1.0, 0.5),
        Align::XMinYMax => (0.0, 1.0),
        Align::XMidYMax => (0.5, 1.0),
        Align::XMaxYMax => (1.0, 1.0),
    };
    let rest = size - view.size * scale;
    DAffine2::from_translation(rest * DVec2::new(x, y))
        * DAffine2::from_scale(scale)
        * DAffine2::from_translation(-view.min)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fitted(attributes: &str) -> (DVec2, DVec2) {
        let text = format!("<svg viewBox='10 20 100 50' {attributes}/>");
        let document = roxmltree::Document::parse(&text).unwrap();
        let root = document.root_element();
        let map = fit(&root, &view_box(&root).unwrap(), DVec2::new(300.0, 300.0));
        (map.transform_point2(DVec2::new(10.0, 20.0)), map.transform_point2(DVec2::new(110.0, 70.0)))
    }

    #[test]
    fn view_boxes_are_fitted() {
        let at = DVec2::new;
        assert_eq!(fitted(""), (at(0.0, 75.0), at(300.0, 225.0)));
        assert_eq!(fitted("preserveAspectRatio='none'"), (at(0.0, 0.0), at(300.0, 300.0)));
        assert_eq!(fitted("preserveAspectRatio='xMaxYMin slice'"), (at(-300.0, 0.0), at(300.0, 300.0)));
    }

    #[test]
    fn transforms_are_read_in_order() {
        let map = transform("translate(10) rotate(90 1 1), scale(2)", "transform").unwrap();
        assert!(map.transform_point2(DVec2::new(1.0, 0.0)).distance(DVec2::new(12.0, 2.0)) < 1e-12);
        assert!(transform("turn(3)", "transform").is_err());
        for flat in ["scale(0)", "scale(0 1)", "matrix(1 2 2 4 0 0)", "skewX(90)"] {
            let map = transform(flat, "transform").unwrap();
            assert!(!is_regular(&map) || flat == "skewX(90)", "{flat}");
        }
        assert!(is_regular(&transform("scale(1e-8)", "transform").unwrap()));
    }
}
