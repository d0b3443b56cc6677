//! Tests that feed broken files to a child process: what runs away there stops there.

use std::process::{Command, Stdio};

/// Runs a test in a child with the number of mutations in a variable of its environment: ten thousand where the compiler has done its best. It is to
/// end well, and to say how much memory it held at most.
pub(crate) fn break_in_a_child(test: &str, variable: &str, limit_kib: u64) {
    let optimised = !cfg!(debug_assertions);
    let mutations = std::env::var("SURFACE_SPLINES_ROUNDS").ok().and_then(|text| text.parse().ok());
    let mutations: u32 = mutations.unwrap_or(if optimised { 10_000 } else { 2_500 });
    if mutations < 10_000 {
        println!("{mutations} mutations; 10,000 in a release build");
    }
    // The address space is limited so that a runaway stops, the memory that was held is what counts.
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -v 2097152; exec \"$0\" \"$@\""]).arg(std::env::current_exe().unwrap());
    command.args(["--exact", test, "--nocapture", "--test-threads=1"]);
    let output = command.env(variable, mutations.to_string()).stderr(Stdio::piped()).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let peak = said.lines().find_map(|line| line.strip_prefix("peak KiB: ")).and_then(|n| n.parse::<u64>().ok());
    assert!(peak.is_some_and(|peak| peak < limit_kib), "{peak:?} KiB");
}
