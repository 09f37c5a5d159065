//! `lafet coverage`: how many jets reach each square metre of a site.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;
use lafet_place::coverage::Coverage;
use lafet_texts::{Shown, Text as _, cli as text};

use super::exercise::write;
use crate::coverage::{file, picture, report};
use crate::failure::{Failure, Outcome};
use crate::lang::current;
use crate::out::Out;

/// Longest file that is read, bytes.
const FILE_MAX: u64 = 1 << 20;

/// Arguments of `lafet coverage`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  lafet coverage hub.toml\n  lafet coverage site.toml\n  lafet coverage site.toml --svg site.svg\n  \
                  lafet --json coverage site.toml --grid"
)]
pub struct CoverageArgs {
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    #[arg(long)]
    grid: bool,
}

/// Computes and shows the coverage.
pub fn run(args: &CoverageArgs, out: &mut Out) -> Outcome {
    let text = read(&args.file)?;
    let plan = file::load(&args.file.display().to_string(), &text).map_err(Failure::Usage)?;
    let coverage = Coverage::of(&plan.site, &plan.area)
        .map_err(|problem| Failure::Usage(problem.0.of(current()).to_owned()))?;
    if let Some(path) = &args.svg {
        write(path, &picture::svg(&plan, &coverage))?;
    }
    out.show(report::text(&plan, &coverage), || report::json(&plan, &coverage, args.grid))
}

fn read(path: &Path) -> Result<String, Failure> {
    let shown = path.display();
    let failed = |error| {
        let what = text::CannotReadSite { shown: Shown(&shown) }.of(current());
        Failure::io(what, error)
    };
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(failed)?;
    file.take(FILE_MAX + 1).read_to_string(&mut text).map_err(failed)?;
    if text.len() as u64 <= FILE_MAX {
        return Ok(text);
    }
    Err(Failure::Usage(text::SiteTooLong { shown: Shown(shown) }.of(current())))
}
