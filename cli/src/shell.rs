//! `linewright completions` and `linewright man`: what the command line offers, for shells and for `man`.
//!
//! Both follow from the definitions that the command line is read by.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::CommandFactory;
use clap_complete::Shell;
use miette::{IntoDiagnostic, WrapErr};

use crate::Cli;

/// Print what a shell needs to complete this command.
#[derive(Debug, clap::Args)]
#[command(after_help = "bash:  linewright completions bash > ~/.local/share/bash-completion/completions/linewright\n\
    zsh:   linewright completions zsh > a directory of $fpath, as _linewright\n\
    fish:  linewright completions fish > ~/.config/fish/completions/linewright.fish")]
pub struct CompletionsArgs {
    /// Shell.
    shell: Shell,
}

/// `linewright completions`
pub fn completions(args: &CompletionsArgs) -> miette::Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "linewright", &mut script);
    crate::out::bytes(&script);
    Ok(ExitCode::SUCCESS)
}

/// Write the manual pages: one of the command, one of each of its subcommands.
#[derive(Debug, clap::Args)]
#[command(after_help = "For example:  linewright man ~/.local/share/man/man1  and then  man linewright-check")]
pub struct ManArgs {
    /// Directory to write to; created if missing.
    dir: PathBuf,
}

/// `linewright man`
pub fn man(args: &ManArgs) -> miette::Result<ExitCode> {
    let dir = &args.dir;
    std::fs::create_dir_all(dir).into_diagnostic().wrap_err_with(|| format!("cannot make {}", dir.display()))?;
    clap_mangen::generate_to(Cli::command().disable_help_subcommand(true), dir)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot write to {}", dir.display()))?;
    crate::out::say!("wrote the manual pages into {}", dir.display());
    Ok(ExitCode::SUCCESS)
}
