//! The program as its users meet it: what it prints, and how it refuses.

use std::process::Output;

use assert_cmd::Command;

pub(crate) fn run(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_whitefurnace")).args(args).output().expect("the program starts")
}

pub(crate) fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

/// Standard output of a run that must end with `status` and say nothing on standard error.
#[track_caller]
pub(crate) fn stdout(args: &[&str], status: i32) -> String {
    let output = run(args);
    assert_eq!(output.status.code(), Some(status), "{args:?}\n{}{}", text(&output.stdout), text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{args:?}");
    text(&output.stdout).into()
}

/// Bad input: exit 2, nothing on standard output, and one line that says every needle.
#[track_caller]
pub(crate) fn refused(args: &[&str], needles: &[&str]) {
    let output = run(args);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {error}");
    assert_eq!(text(&output.stdout), "", "{args:?}");
    assert!(error.starts_with("error: ") && error.ends_with('\n') && error.lines().count() == 1, "{args:?}: {error}");
    for needle in needles {
        assert!(error.contains(needle), "{args:?}: {error}");
    }
    assert!(!error.contains("panicked"), "{error}");
}
