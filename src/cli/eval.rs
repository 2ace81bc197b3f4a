//! `whitefurnace eval`: f, f·cos and the pdf for one pair of directions, one `key values…` a line.

use std::io::Write;

use super::Status;
use super::job::Eval;
use crate::report::table::exact;

pub(super) fn run(job: &Eval, out: &mut dyn Write) -> anyhow::Result<Status> {
    let Eval { subject, wo, wi } = job;
    let f = subject.bsdf.eval(*wo, *wi);
    // Plus 0, so that no −0 is shown.
    let mut line = |key: &str, v: [f64; 3]| writeln!(out, "{key} {}", v.map(|x| exact(x + 0.0)).join(" "));
    line("f", f.to_array())?;
    line("f_cos", (f * wi.z.abs()).to_array())?;
    line("wo", wo.to_array())?;
    line("wi", wi.to_array())?;
    writeln!(out, "pdf {}", exact(subject.bsdf.pdf(*wo, *wi)))?;
    Ok(Status::Pass)
}
