//! Saving: killed at any time, on a full disk, in a folder that cannot be written.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use bevy_surface_splines::format::document::{Document, SurfaceReference};
use bevy_surface_splines::format::save::{SaveError, SaveStep, replace_file};

use super::{build, everything, mesh};
use crate::Random;

/// Tells a child process where to save, and how.
const CHILD_FILE: &str = "SURFACE_SPLINES_SAVE_TO";
const CHILD_TASK: &str = "SURFACE_SPLINES_SAVE_HOW";
const KILLS: u32 = 200;
const KILLS_WHILE_WRITING: u32 = 50;

/// A folder of its own for a test, empty.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("documents_{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn listed(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned());
    let mut names: Vec<String> = entries.collect();
    names.sort();
    names
}

/// Two documents of different length, by turns the old and the new one.
fn documents() -> [Document; 2] {
    let surface = build(&mesh(20, 10));
    let whole = everything(&surface);
    let mut short = Document::new(SurfaceReference::of(&surface));
    short.view = whole.view;
    [whole, short]
}

fn child(task: &str, path: &Path) -> Command {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["--exact", "documents::saving::child_saves", "--nocapture", "--test-threads=1"]);
    command.env(CHILD_FILE, path).env(CHILD_TASK, task).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Not a test of its own: what the child processes run.
#[test]
fn child_saves() {
    let Some(path) = std::env::var_os(CHILD_FILE).map(PathBuf::from) else { return };
    let documents = documents();
    match std::env::var(CHILD_TASK).as_deref() {
        // Saves again and again, every other time so slowly that a kill mostly meets the time of writing.
        Ok("forever") => {
            let texts = documents.each_ref().map(|d| d.to_ron().unwrap());
            println!("\nREADY");
            for i in (0..2).cycle() {
                documents[i].save(&path).unwrap();
                replace_file(&path, |file| slowly(file, texts[1 - i].as_bytes())).unwrap();
            }
        }
        Ok("once") => match documents[1].save(&path) {
            Ok(()) => println!("\nSAVED"),
            Err(error) => println!("\nREFUSED\t{error}"),
        },
        _ => {
            let long = [&documents[0]; 100].map(|d| d.to_ron().unwrap()).concat();
            match replace_file(&path, |file| file.write_all(long.as_bytes())) {
                Ok(()) => println!("\nSAVED"),
                Err(error) => println!("\nREFUSED\t{error}"),
            }
        }
    }
}

fn slowly(file: &mut dyn Write, bytes: &[u8]) -> std::io::Result<()> {
    for piece in bytes.chunks(1_000.max(bytes.len() / 8)) {
        file.write_all(piece)?;
        file.flush()?;
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(())
}

#[test]
fn kills_leave_a_whole_document_and_no_litter() {
    let folder = folder("kills");
    let path = folder.join("killed.splines.ron");
    let texts = documents().map(|d| d.to_ron().unwrap());
    documents()[0].save(&path).unwrap();
    let foreign = folder.join(".killed.splines.ron.0123456789abcdef.12-x.being-saved");
    fs::write(&foreign, "foreign").unwrap();
    let mut random = Random(0x0dead);
    println!("seed 0x0dead");
    let (mut while_writing, mut found) = (0, [0; 2]);
    for _ in 0..KILLS {
        let mut child = child("forever", &path).stderr(Stdio::null()).spawn().unwrap();
        wait_for(&mut child, "READY");
        std::thread::sleep(Duration::from_micros(random.next() % 25_000));
        child.kill().unwrap();
        child.wait().unwrap();
        // A file that is left over was made and not renamed yet.
        let left = listed(&folder).len() - 2;
        assert!(left <= 1, "{:?}", listed(&folder));
        while_writing += left as u32;
        // The next start.
        let text = Document::open(&path).unwrap().to_ron().unwrap();
        let which = texts.iter().position(|t| *t == text).expect("the old or the new one");
        assert_eq!(fs::read_to_string(&path).unwrap(), texts[which]);
        found[which] += 1;
        assert_eq!(listed(&folder).len(), 2, "{:?}", listed(&folder));
    }
    println!("{KILLS} kills, {while_writing} of them between making the new file and renaming it; {found:?}");
    assert!(while_writing >= KILLS_WHILE_WRITING && found[0] > 0 && found[1] > 0);
    assert_eq!(fs::read_to_string(foreign).unwrap(), "foreign");
}

fn wait_for(child: &mut Child, word: &str) {
    let mut said = BufReader::new(child.stdout.take().unwrap());
    let mut line = String::new();
    while line.trim_end() != word {
        line.clear();
        assert!(said.read_line(&mut line).unwrap() > 0, "the child ended");
    }
}

/// What a child says of an attempt to save.
fn outcome(mut command: Command) -> String {
    let output = command.output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = said.lines().find(|line| line.starts_with("SAVED") || line.starts_with("REFUSED"));
    line.unwrap_or_else(|| panic!("{said}{}", String::from_utf8_lossy(&output.stderr))).to_owned()
}

#[cfg(unix)]
#[test]
fn a_full_disk_keeps_the_old_file() {
    let folder = folder("full");
    let path = folder.join("full.splines.ron");
    documents()[0].save(&path).unwrap();
    let old = fs::read(&path).unwrap();
    // No file may become longer than 64 blocks of 512 bytes (some shells count 1,024); without the signal, writing fails.
    let inner = child("long", &path);
    let mut limited = Command::new("sh");
    limited
        .args(["-c", "ulimit -f 64; trap '' XFSZ; exec \"$0\" \"$@\""])
        .arg(inner.get_program())
        .args(inner.get_args());
    limited.env(CHILD_FILE, &path).env(CHILD_TASK, "long");
    let said = outcome(limited);
    println!("{said}");
    assert!(said.starts_with("REFUSED") && said.contains("make room") && said.contains("cannot be written"), "{said}");
    assert_eq!((fs::read(&path).unwrap(), listed(&folder)), (old, vec!["full.splines.ron".to_owned()]));
    // And a small disk that is really full, where the system lets one be made.
    let small = folder.join("small");
    fs::create_dir(&small).unwrap();
    let script = "mount -t tmpfs -o size=64k none \"$SMALL\" && echo old > \"$SMALL/a\" && \"$0\" \"$@\" && \
                  echo \"\nKEPT $(ls -A \"$SMALL\") $(cat \"$SMALL/a\")\"";
    let mut command = Command::new("unshare");
    command.args(["-Urm", "sh", "-c", script]).arg(inner.get_program()).args(inner.get_args());
    command.env(CHILD_FILE, small.join("a")).env(CHILD_TASK, "long").env("SMALL", &small);
    let output = command.output().map(|o| String::from_utf8_lossy(&o.stdout).into_owned()).unwrap_or_default();
    match output.lines().find(|line| line.starts_with("REFUSED") || line.starts_with("SAVED")) {
        Some(said) => {
            println!("{said}");
            assert!(said.contains("make room") && output.contains("KEPT a old"), "{output}");
        }
        None => println!("no small disk can be made here; the limit on files stands for it"),
    }
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_keeps_the_old_file() {
    use std::os::unix::fs::PermissionsExt;
    use std::os::unix::process::CommandExt;
    let folder = folder("read_only");
    let path = folder.join("kept.splines.ron");
    documents()[0].save(&path).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o666)).unwrap();
    let old = fs::read(&path).unwrap();
    let set = |mode| fs::set_permissions(&folder, fs::Permissions::from_mode(mode)).unwrap();
    set(0o555);
    let probe = folder.join("probe");
    let may_write_all_the_same = fs::write(&probe, "").is_ok();
    let program = std::env::temp_dir().join(format!("splines-child-{}", std::process::id()));
    let mut command = child("once", &path);
    if may_write_all_the_same {
        fs::remove_file(probe).unwrap();
        // Permissions mean nothing to the superuser; the child is somebody else, and must reach the program.
        fs::copy(std::env::current_exe().unwrap(), &program).unwrap();
        let mut other = Command::new(&program);
        other.args(command.get_args()).stdout(Stdio::piped()).stderr(Stdio::piped()).current_dir(std::env::temp_dir());
        other.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
        other.uid(65_534).gid(65_534);
        command = other;
    }
    let said = outcome(command);
    let _ = fs::remove_file(&program);
    set(0o755);
    println!("{said}");
    assert!(said.starts_with("REFUSED") && said.contains("save where you may write"), "{said}");
    assert_eq!((fs::read(&path).unwrap(), listed(&folder)), (old, vec!["kept.splines.ron".to_owned()]));
    // A file in the place of the folder, and no folder.
    for (bad, remedy) in [(path.join("x.ron"), "make the folder"), (folder.join("no/x.ron"), "make the folder")] {
        let error: SaveError = replace_file(&bad, |file| file.write_all(b"x")).unwrap_err();
        assert!(error.step == SaveStep::Create && error.to_string().contains(remedy), "{error}");
    }
    assert_eq!(listed(&folder), ["kept.splines.ron"]);
}

#[test]
fn many_may_save_one_file() {
    let folder = folder("many");
    let path = folder.join("many.splines.ron");
    let documents = documents();
    let texts = documents.each_ref().map(|d| d.to_ron().unwrap());
    std::thread::scope(|scope| {
        for document in documents.iter().cycle().take(6) {
            scope.spawn(|| (0..20).for_each(|_| document.save(&path).unwrap()));
        }
    });
    assert!(texts.contains(&fs::read_to_string(&path).unwrap()));
    assert_eq!(listed(&folder), ["many.splines.ron"]);
}
