//! `luxmc man`: the manual pages of the program and of every command.

use std::path::PathBuf;

use clap::{Args, Command};
use clap_mangen::Man;

use super::exit::{Exit, Failure};
use super::{Outcome, console};
use crate::output::{ResultFile, write_files};

const EXAMPLES: &str = "\
Examples:
  luxmc man | man -l -                        the page of the program
  luxmc man solve | man -l -                  that of a command
  luxmc man --out ~/.local/share/man/man1     all of them, for man luxmc and man luxmc-solve";

/// Arguments of `luxmc man`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ManArguments {
    /// Command whose page is printed [default: the program]
    #[arg(value_name = "COMMAND", conflicts_with = "out")]
    command: Option<String>,
    /// Write all pages into this directory instead
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Prints one page, or writes all pages into a directory.
pub fn run(arguments: &ManArguments, mut program: Command) -> Outcome {
    program.build();
    if let Some(directory) = &arguments.out {
        write_files(directory, &pages(&program)?)?;
        return Ok(Exit::Done);
    }
    let page = match &arguments.command {
        None => page(&program)?,
        Some(name) => page(named(&program, name)?)?,
    };
    console::result(&String::from_utf8_lossy(&page.bytes))?;
    Ok(Exit::Done)
}

fn commands(program: &Command) -> impl Iterator<Item = &Command> {
    program.get_subcommands().filter(|command| command.get_name() != "help")
}

fn named<'c>(program: &'c Command, name: &str) -> Result<&'c Command, Failure> {
    commands(program).find(|command| command.get_name() == name).ok_or_else(|| Failure::Usage {
        what: "no command has this name".to_owned(),
        got: format!("{name:?}"),
        expected: commands(program).map(Command::get_name).collect::<Vec<_>>().join(", "),
        remedy: "name one of those".to_owned(),
    })
}

fn pages(program: &Command) -> Result<Vec<ResultFile>, Failure> {
    std::iter::once(program).chain(commands(program)).map(page).collect()
}

/// A page in troff, with the file name that `man` expects.
fn page(command: &Command) -> Result<ResultFile, Failure> {
    let title = command.get_display_name().unwrap_or(command.get_name()).replace(' ', "-");
    let mut bytes = Vec::new();
    Man::new(command.clone()).title(title.clone()).render(&mut bytes).map_err(Failure::StandardOutput)?;
    Ok(ResultFile { name: format!("{title}.1"), bytes })
}
