//! Rebuilds the bundled models: one should see `assets/pebble.obj` and `assets/eel.glb` written, and `git diff` empty afterwards.
//!
//! The pebble is a ring of stone, the eel a skinned model with a clip.
//!
//! `cargo run --no-default-features --example make_assets`

mod eel;
mod glb;
mod pebble;

use std::path::PathBuf;

fn main() -> std::io::Result<()> {
    for (name, bytes) in files() {
        let path = asset(name);
        std::fs::write(&path, &bytes)?;
        println!("{}: {} bytes", path.display(), bytes.len());
    }
    Ok(())
}

fn files() -> [(&'static str, Vec<u8>); 2] {
    [("pebble.obj", pebble::file().into_bytes()), ("eel.glb", eel::file())]
}

fn asset(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("assets").join(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bundled_files_are_what_the_generator_makes() {
        for (name, made) in files() {
            let bundled = std::fs::read(asset(name)).expect("run the example to write the file");
            // A checkout may have other ends of lines.
            let plain = |bytes: Vec<u8>| if name.ends_with(".glb") { bytes } else { without_returns(bytes) };
            assert!(plain(bundled) == made, "{name}: run the example and commit the file it writes");
        }
    }

    fn without_returns(bytes: Vec<u8>) -> Vec<u8> {
        bytes.into_iter().filter(|byte| *byte != b'\r').collect()
    }
}
