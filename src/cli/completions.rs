//! `luxmc completions`: the script that lets a shell complete commands and options.

use clap::{Args, Command};
use clap_complete::Shell;

use super::exit::Exit;
use super::method::words_of;
use super::{Outcome, console};

const EXAMPLES: &str = "\
Examples:
  luxmc completions bash > ~/.local/share/bash-completion/completions/luxmc
  luxmc completions zsh > \"${fpath[1]}/_luxmc\"
  luxmc completions fish > ~/.config/fish/completions/luxmc.fish";

/// Arguments of `luxmc completions`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CompletionsArguments {
    /// Shell to complete in
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the completions of a program.
pub fn run(arguments: &CompletionsArguments, program: Command) -> Outcome {
    // These options are parsed by functions, which do not list their possible words to a shell.
    let mut program = program.mut_subcommands(|command| {
        command.mut_args(|option| match words_of(option.get_id().as_str()) {
            Some(words) => option.value_parser(words),
            None => option,
        })
    });
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "luxmc", &mut script);
    console::result(&String::from_utf8_lossy(&script))?;
    Ok(Exit::Done)
}
