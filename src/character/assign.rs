//! Which part a shape belongs to.

use std::collections::HashMap;

use super::check::{Flaw, flaw};
use super::locate::Step;
use super::{Character, CharacterFault};

impl Character {
    /// The part of each shape: that which names its id, or else the innermost group about it that one names. Shapes that are not painted need
    /// none.
    pub(super) fn assign(&self) -> Result<Vec<Option<usize>>, Flaw> {
        let mut named: HashMap<&str, (usize, bool)> = HashMap::new();
        let at = |part: usize, place: usize| {
            [Step::Field("parts"), Step::Item(part), Step::Field("shapes"), Step::Item(place)]
        };
        for (number, part) in self.parts.iter().enumerate() {
            for (place, id) in part.shapes.iter().enumerate() {
                if let Some((other, _)) = named.insert(id, (number, false)) {
                    let other = self.parts.get(other).map(|part| part.name.clone()).unwrap_or_default();
                    let fault = CharacterFault::SameShape { id: id.clone(), other };
                    return Err(flaw(&at(number, place), &format!("part `{}`", part.name), fault));
                }
            }
        }
        let mut part_named = |id: &str| {
            named.get_mut(id).map(|(part, found)| {
                *found = true;
                *part
            })
        };
        // Groups come behind those that they lie in.
        let mut of_groups: Vec<Option<usize>> = Vec::with_capacity(self.drawing.groups.len());
        for group in &self.drawing.groups {
            let around = group.parent.and_then(|parent| of_groups.get(parent as usize).copied().flatten());
            of_groups.push(part_named(&group.id).or(around));
        }
        let mut assigned = Vec::with_capacity(self.drawing.shapes.len());
        for shape in &self.drawing.shapes {
            let group = shape.group.and_then(|group| of_groups.get(group as usize).copied().flatten());
            let part = shape.id.as_deref().and_then(&mut part_named).or(group);
            if part.is_none() && shape.style.is_visible() {
                let shape = match &shape.id {
                    Some(id) => format!("shape `{id}`"),
                    None => format!("a `{}` without an id", shape.element),
                };
                return Err(flaw(&[Step::Field("parts")], "the character", CharacterFault::NotInAPart { shape }));
            }
            assigned.push(part);
        }
        for (number, part) in self.parts.iter().enumerate() {
            for (place, id) in part.shapes.iter().enumerate() {
                if named.get(id.as_str()).is_some_and(|(_, found)| !found) {
                    let fault = CharacterFault::NoSuchShape { id: id.clone(), drawing: self.drawing_path.clone() };
                    return Err(flaw(&at(number, place), &format!("part `{}`", part.name), fault));
                }
            }
        }
        Ok(assigned)
    }
}
