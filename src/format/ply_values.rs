//! The values of a PLY file, written out or binary.

use super::error::{Cause, Fault};
use super::text::Text;

/// The type of a PLY value.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    pub(super) fn parse(word: &[u8]) -> Option<Self> {
        Some(match word {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A source of values, row by row. Every PLY type fits an `f64` exactly.
pub(super) trait Values {
    /// Bytes by which the last value may be shorter than the others.
    const SLACK: u64;

    /// The fewest bytes that a value takes.
    fn least_bytes(kind: Scalar) -> u64;

    /// Bytes not yet read.
    fn room(&self) -> u64;

    /// A fault at the value read last.
    fn fault(&self, cause: Cause) -> Fault;

    /// Goes to the start of a row.
    fn begin_row(&mut self, part: &'static str) -> Result<(), Fault>;

    /// Reads one value.
    fn scalar(&mut self, kind: Scalar) -> Result<f64, Fault>;

    /// Leaves the row.
    fn end_row(&mut self);
}

/// Values written as text, one row a line.
pub(super) struct Written<'a> {
    text: Text<'a>,
}

impl<'a> Written<'a> {
    pub(super) fn new(text: Text<'a>) -> Self {
        Self { text }
    }
}

impl Values for Written<'_> {
    const SLACK: u64 = 1;

    /// A digit and a blank or line end.
    fn least_bytes(_: Scalar) -> u64 {
        2
    }

    fn room(&self) -> u64 {
        self.text.room() as u64
    }

    fn fault(&self, cause: Cause) -> Fault {
        Fault::line(self.text.line(), cause)
    }

    fn begin_row(&mut self, part: &'static str) -> Result<(), Fault> {
        if self.text.seek_word() { Ok(()) } else { Err(self.fault(Cause::EndsEarly(part))) }
    }

    fn scalar(&mut self, _: Scalar) -> Result<f64, Fault> {
        self.text.number("a number")
    }

    fn end_row(&mut self) {
        self.text.next_line();
    }
}

/// Binary values.
pub(super) struct Binary<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Where the value read last starts.
    last: usize,
    big_endian: bool,
    part: &'static str,
}

impl<'a> Binary<'a> {
    /// Reads from byte `at` of the whole file.
    pub(super) fn new(bytes: &'a [u8], at: usize, big_endian: bool) -> Self {
        Self { bytes, at, last: at, big_endian, part: "the body" }
    }

    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Fault> {
        self.last = self.at;
        match self.bytes.get(self.at..).and_then(|rest| rest.first_chunk::<N>()) {
            Some(bytes) => {
                self.at += N;
                let mut bytes = *bytes;
                if self.big_endian {
                    bytes.reverse();
                }
                Ok(bytes)
            }
            None => Err(Fault::byte(self.at, Cause::EndsEarly(self.part))),
        }
    }
}

impl Values for Binary<'_> {
    const SLACK: u64 = 0;

    fn least_bytes(kind: Scalar) -> u64 {
        kind.bytes() as u64
    }

    fn room(&self) -> u64 {
        (self.bytes.len() - self.at) as u64
    }

    fn fault(&self, cause: Cause) -> Fault {
        Fault::byte(self.last, cause)
    }

    #[inline]
    fn begin_row(&mut self, part: &'static str) -> Result<(), Fault> {
        self.part = part;
        Ok(())
    }

    #[inline]
    fn scalar(&mut self, kind: Scalar) -> Result<f64, Fault> {
        Ok(match kind {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    #[inline]
    fn end_row(&mut self) {}
}
