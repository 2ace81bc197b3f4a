//! `whitefurnace notebooks-data`: the files that the figures and the notebooks are made of.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use anyhow::Context;

use super::validate::{print, progress_bar};
use super::{Status, job};
use crate::report::figures::{INDEX, SETS, index};

pub(super) const HELP: &str = "The same bytes come out on every run and any number of threads. index.json says what each file \
    and column is.\n\nExamples:\n  whitefurnace notebooks-data\n  whitefurnace notebooks-data --out /tmp/data";

/// What `notebooks-data` takes.
#[derive(Debug, clap::Args)]
pub(super) struct NotebooksDataArgs {
    /// Folder for the files; it is made where it is not there
    #[arg(long, value_name = "DIR", default_value = "notebooks-data")]
    out: PathBuf,
}

pub(super) fn run(args: &NotebooksDataArgs, out: &mut dyn Write) -> anyhow::Result<Status> {
    let shown = args.out.display();
    fs::create_dir_all(&args.out).with_context(|| format!("--out {shown}: cannot be made"))?;
    let file = |name: &str| job::target("--out", args.out.join(name));
    // All are looked at before the first is made.
    let names = SETS.iter().flat_map(|set| set.files).map(|file| file.name);
    let targets = names.map(file).collect::<anyhow::Result<Vec<_>>>()?;
    let index_target = file(INDEX)?;
    let bar = progress_bar(SETS.len(), "sets");
    let mut targets = targets.iter();
    let (mut files, mut bytes) = (1, 0);
    for set in SETS {
        bar.set_message(set.name);
        let contents = (set.make)();
        for (content, target) in contents.iter().zip(&mut targets) {
            target.write(content.as_bytes()).with_context(|| format!("--out {shown}: cannot be written"))?;
            files += 1;
            bytes += content.len();
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let index = index();
    index_target.write(index.as_bytes()).with_context(|| format!("--out {shown}: cannot be written"))?;
    print(out, &format!("{shown}: {files} files, {} KiB\n", (bytes + index.len()).div_ceil(1024)))?;
    Ok(Status::Pass)
}
