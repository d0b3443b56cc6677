//! Reading files that come to an end.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Reads a regular file, at most `limit` bytes of it. Devices and pipes are refused, since they may never end.
pub(crate) fn read_file(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let metadata = path.metadata()?;
    if !metadata.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is not a regular file"));
    }
    let length = metadata.len().min(limit);
    let mut bytes = Vec::new();
    let reserved = bytes.try_reserve_exact(usize::try_from(length).unwrap_or(usize::MAX));
    reserved.map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    File::open(path)?.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}
