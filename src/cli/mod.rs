//! The command line: what was typed (`args`) becomes what it means (`job`), and each subcommand has its file.
//!
//! Exit status: 0 all is well; 1 a check failed; 3 nothing failed, but something could not be decided (a check was
//! inconclusive, an integral did not meet its tolerance); 2 bad usage or input, with one line on standard error.
//! A reader that closes standard output early (`| head`) is no error.

mod albedo;
mod args;
mod compare;
mod contact_sheet;
mod converge;
mod eval;
mod furnace;
mod job;
mod list;
mod merge;
mod notebooks_data;
mod photons;
mod picture;
mod plot;
mod progress;
mod radiosity;
mod render;
mod sample;
mod scene_source;
mod scenes;
mod selftest;
mod subjects;
mod validate;

use std::ffi::OsString;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::process::ExitCode;

use clap::error::{ContextKind, ErrorKind};
use clap::{CommandFactory, Parser};

use args::{Args, Command};

/// How a command that ran to its end ended. The discriminant is the exit status.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Status {
    Pass = 0,
    Fail = 1,
    Inconclusive = 3,
}

/// Exit status of bad usage and bad input.
const BAD_INPUT: u8 = 2;

/// Runs the program with the arguments of the process.
pub fn main() -> ExitCode {
    run(std::env::args_os())
}

fn run(typed: impl Iterator<Item = OsString>) -> ExitCode {
    let result = Args::try_parse_from(typed).map_err(anyhow::Error::from).and_then(|args| dispatch(args.command));
    match result {
        Ok(status) => ExitCode::from(status as u8),
        Err(error) => match error.downcast_ref::<clap::Error>() {
            Some(asked) if matches!(asked.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
                let _ = asked.print();
                ExitCode::SUCCESS
            }
            Some(usage) => complain(&one_line_of_usage(usage)),
            None if is_closed_pipe(&error) => ExitCode::SUCCESS,
            None => complain(&whole_chain(&error)),
        },
    }
}

fn dispatch(command: Command) -> anyhow::Result<Status> {
    let stdout = io::stdout();
    let terminal = stdout.is_terminal();
    let mut out = BufWriter::new(stdout.lock());
    let status = match command {
        Command::List(args) => list::run(&args, &mut out),
        Command::Validate(args) => validate::run(job::validate(args)?, &mut out, terminal),
        Command::Albedo(args) => albedo::run(&job::albedo(args)?, &mut out),
        Command::Eval(args) => eval::run(&job::eval(&args)?, &mut out),
        Command::Sample(args) => sample::run(&job::sample(&args)?, &mut out),
        Command::Furnace(args) => furnace::run(args, &mut out, terminal),
        Command::Converge(args) => converge::run(&args, &mut out),
        Command::ContactSheet(args) => contact_sheet::run(&args, &mut out),
        Command::NotebooksData(args) => notebooks_data::run(&args, &mut out),
        Command::Scenes(args) => scenes::run(&args, &mut out),
        Command::Render(args) => render::run(&args, &mut out),
        Command::Radiosity(args) => radiosity::run(&args, &mut out),
        Command::ViewFactors(args) => radiosity::run_view_factors(&args, &mut out),
        Command::Photons(args) => photons::run(&args, &mut out),
        Command::Compare(args) => compare::run(&compare::job(args)?, &mut out, terminal),
        Command::Merge(args) => merge::run(merge::job(args)?, &mut out),
        Command::Plot(args) => plot::run(&args, &mut out),
        Command::Selftest => selftest::run(&mut out),
    }?;
    // A verdict stands, whether or not anyone still reads the text.
    ignore_closed_pipe(out.flush())?;
    Ok(status)
}

/// The error with its causes, leaving out those that it has quoted already.
fn whole_chain(error: &anyhow::Error) -> String {
    error.chain().map(ToString::to_string).fold(String::new(), |text, cause| match text.as_str() {
        "" => cause,
        said if said.contains(&cause) => text,
        said => format!("{said}: {cause}"),
    })
}

/// Prints one line on standard error.
fn complain(message: &str) -> ExitCode {
    let line: Vec<&str> = message.split_whitespace().collect();
    let _ = writeln!(io::stderr(), "error: {}", line.join(" "));
    ExitCode::from(BAD_INPUT)
}

/// The error of a wrong command line without its usage text, on one line.
fn one_line_of_usage(error: &clap::Error) -> String {
    let known = || {
        // The usage names the command that lacks one below it.
        let usage = error.get(ContextKind::Usage).map(ToString::to_string).unwrap_or_default();
        let mut command = Args::command();
        for word in usage.split_whitespace() {
            command = command.find_subcommand(word).cloned().unwrap_or(command);
        }
        command.get_subcommands().map(|c| c.get_name().to_string()).collect::<Vec<_>>().join(", ")
    };
    match error.kind() {
        // These render as the whole help text, or name no command at all.
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
            return format!("no command is given; known are {}", known());
        }
        ErrorKind::InvalidSubcommand if error.get(ContextKind::SuggestedSubcommand).is_none() => {
            let typed = error.get(ContextKind::InvalidSubcommand).map(ToString::to_string).unwrap_or_default();
            return format!("unrecognized subcommand '{typed}'; known are {}", known());
        }
        _ => {}
    }
    let text = error.to_string();
    let paragraphs = text.split("\n\n").map(str::trim);
    let kept: Vec<&str> = paragraphs
        .filter(|p| !p.is_empty() && !p.starts_with("Usage:") && !p.starts_with("For more information"))
        .map(|p| p.trim_start_matches("error: "))
        .collect();
    format!("{}; see whitefurnace --help", kept.join("; ").replace('\n', " "))
}

fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let io_error = |cause: &(dyn std::error::Error + 'static)| cause.downcast_ref::<io::Error>().map(io::Error::kind);
    error.chain().filter_map(io_error).any(|kind| kind == io::ErrorKind::BrokenPipe)
}

/// `result`, but a reader who has gone away is no error.
fn ignore_closed_pipe(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}
