//! Long work: a bar that shows how far it is, and Ctrl-C that ends it in good order.

use std::io::{self, IsTerminal};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Set by Ctrl-C.
pub(super) fn interruption() -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    // It fails where a handler is set already, and that one does the same.
    let _ = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed));
    interrupted
}

/// A bar of a thousand steps on standard error; hidden where that is no terminal.
pub(super) fn bar(quiet: bool) -> ProgressBar {
    let visible = !quiet && io::stderr().is_terminal();
    let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(1000), target);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}") {
        bar.set_style(style);
    }
    bar
}

/// What is under way and for how long, on standard error, where nobody knows how far it is; hidden where that is no terminal.
pub(super) fn clock(quiet: bool, what: String) -> ProgressBar {
    let clock = bar(quiet);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}  {elapsed}") {
        clock.set_style(style);
    }
    clock.set_message(what);
    clock.enable_steady_tick(Duration::from_millis(200));
    clock
}

/// Moves the bar to this share of the work, `seconds` after `share` was `first`.
pub(super) fn show(bar: &ProgressBar, message: &str, seconds: f64, first: f64, share: f64) {
    bar.set_position((1000.0 * share) as u64);
    let speed = (share - first) / seconds;
    let left = if speed > 0.0 { format!("{:.0} s left", (1.0 - share) / speed) } else { String::new() };
    bar.set_message(format!("{message}  {left}"));
}
