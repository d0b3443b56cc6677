//! Ranges of numbers, checked while a document is read, where line and column are known.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

use crate::curve::Scheme;

/// Coordinates of positions; those of surfaces are smaller.
const FARTHEST: f64 = 1e76;
/// What a camera can hold, which counts in `f32`.
const VIEW: f64 = 1e30;

/// A number that is not NaN, and lies in a range.
fn within<E: Error>(x: f64, least: f64, most: f64) -> Result<f64, E> {
    if (least..=most).contains(&x) {
        return Ok(x);
    }
    Err(E::custom(format_args!("{x:?} is not a number from {least:?} to {most:?}")))
}

fn all<E: Error, const N: usize>(list: [f64; N], least: f64, most: f64) -> Result<[f64; N], E> {
    list.iter().try_for_each(|x| within(*x, least, most).map(drop))?;
    Ok(list)
}

pub(super) fn position<'de, D: Deserializer<'de>>(d: D) -> Result<[f64; 3], D::Error> {
    all(<[f64; 3]>::deserialize(d)?, -FARTHEST, FARTHEST)
}

pub(super) fn maybe_position<'de, D: Deserializer<'de>>(d: D) -> Result<Option<[f64; 3]>, D::Error> {
    Option::<[f64; 3]>::deserialize(d)?.map(|p| all(p, -FARTHEST, FARTHEST)).transpose()
}

pub(super) fn length<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    within(f64::deserialize(d)?, 0.0, FARTHEST)
}

/// A wished length: larger than any length that fits on a surface, should a program ask for that.
pub(super) fn maybe_length<'de, D: Deserializer<'de>>(d: D) -> Result<Option<f64>, D::Error> {
    Option::<f64>::deserialize(d)?.map(|x| within(x, 0.0, f64::MAX)).transpose()
}

pub(super) fn unit<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    within(f64::deserialize(d)?, 1.0 / FARTHEST, FARTHEST)
}

/// A direction in a face's frame: of length one, or none.
pub(super) fn heading<'de, D: Deserializer<'de>>(d: D) -> Result<Option<(u32, f64, f64)>, D::Error> {
    let heading = Option::<(u32, f64, f64)>::deserialize(d)?;
    if let Some((_, x, y)) = heading {
        let length = x.hypot(y);
        if !(length == 0.0 || (length - 1.0).abs() <= 1e-6) {
            return Err(D::Error::custom(format_args!(
                "the direction ({x:?}, {y:?}) is neither of length one nor zero"
            )));
        }
    }
    Ok(heading)
}

pub(super) fn colour<'de, D: Deserializer<'de>>(d: D) -> Result<[f32; 4], D::Error> {
    let colour = <[f32; 4]>::deserialize(d)?;
    all::<_, 4>(colour.map(f64::from), 0.0, 1.0)?;
    Ok(colour)
}

pub(super) fn width<'de, D: Deserializer<'de>>(d: D) -> Result<f32, D::Error> {
    let width = f32::deserialize(d)?;
    within(f64::from(width), 0.0, 1000.0)?;
    Ok(width)
}

pub(super) fn scheme<'de, D: Deserializer<'de>>(d: D) -> Result<Scheme, D::Error> {
    let scheme = Scheme::deserialize(d)?;
    if scheme.is_sound() { Ok(scheme) } else { Err(D::Error::custom("a length or an angle is not a number")) }
}

pub(super) fn target<'de, D: Deserializer<'de>>(d: D) -> Result<[f64; 3], D::Error> {
    all(<[f64; 3]>::deserialize(d)?, -VIEW, VIEW)
}

pub(super) fn yaw<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    within(f64::deserialize(d)?, -1e6, 1e6)
}

pub(super) fn pitch<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    within(f64::deserialize(d)?, -2.0, 2.0)
}

pub(super) fn distance<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    within(f64::deserialize(d)?, 1.0 / VIEW, VIEW)
}

/// A text of at most `MOST` bytes.
pub(super) fn text<'de, D: Deserializer<'de>, const MOST: usize>(d: D) -> Result<String, D::Error> {
    let text = String::deserialize(d)?;
    if text.len() <= MOST {
        return Ok(text);
    }
    Err(D::Error::custom(format_args!("the text has {} bytes, at most {MOST} are read", text.len())))
}

pub(super) fn maybe_path<'de, D: Deserializer<'de>>(d: D) -> Result<Option<String>, D::Error> {
    const MOST: usize = 4096;
    let path = Option::<String>::deserialize(d)?;
    match &path {
        Some(path) if path.len() > MOST => {
            Err(D::Error::custom(format_args!("the path has {} bytes, at most {MOST} are read", path.len())))
        }
        _ => Ok(path),
    }
}

/// A list of at most `MOST` entries.
pub(super) fn list<'de, D, T, const MOST: usize>(d: D) -> Result<Vec<T>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    struct List<T, const MOST: usize>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>, const MOST: usize> Visitor<'de> for List<T, MOST> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            write!(f, "a list of at most {MOST} entries")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
            let mut out = Vec::new();
            while let Some(entry) = entries.next_element()? {
                if out.len() == MOST {
                    return Err(A::Error::custom(format_args!("the list has more than {MOST} entries")));
                }
                out.push(entry);
            }
            Ok(out)
        }
    }

    d.deserialize_seq(List::<T, MOST>(PhantomData))
}
