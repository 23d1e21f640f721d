//! `sidestep completions` and `sidestep man`: what shells and `man` read, made from the parser itself.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_complete::Shell;
use serde_json::json;

use crate::Global;
use crate::failure::Failure;
use crate::output;

/// Arguments of `completions`.
#[derive(Args)]
#[command(after_help = "Examples:\n  sidestep completions bash > \
    ~/.local/share/bash-completion/completions/sidestep\n  \
    sidestep completions fish > ~/.config/fish/completions/sidestep.fish")]
pub struct CompletionsArgs {
    /// The shell that reads them
    shell: Shell,
}

/// Prints the script for a shell.
pub fn run(args: &CompletionsArgs, mut parser: Command, global: &Global) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut parser, "sidestep", &mut script);
    let script = String::from_utf8_lossy(&script);
    if global.json {
        return output::print_json(&json!({ "shell": args.shell.to_string(), "script": script }));
    }
    output::print(&script)
}

/// Arguments of `man`.
#[derive(Args)]
pub struct ManArgs {
    /// Folder for the pages: sidestep.1, and one for each verb
    #[arg(long)]
    out: PathBuf,
}

/// Writes a manual page for the program and for each verb.
pub fn manual(args: &ManArgs, parser: Command, global: &Global) -> Result<(), Failure> {
    std::fs::create_dir_all(&args.out)
        .map_err(|error| Failure::file(&args.out, format!("cannot be made ({error})")))?;
    let mut parser = parser.disable_help_subcommand(true);
    parser.build();
    let verbs = parser.get_subcommands().filter(|verb| !verb.is_hide_set());
    let mut pages = Vec::new();
    for page in std::iter::once(&parser).chain(verbs) {
        let name = page.get_display_name().unwrap_or(page.get_name());
        let path = args.out.join(format!("{name}.1"));
        let mut text = Vec::new();
        clap_mangen::Man::new(page.clone())
            .render(&mut text)
            .map_err(|error| Failure::file(&path, error))?;
        output::write_file(&path, &text)?;
        pages.push(path);
    }
    if global.json {
        return output::print_json(&json!({ "pages": pages }));
    }
    Ok(())
}
