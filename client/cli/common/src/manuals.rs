//! Man pages and shell completions of a program, for packages.

use clap::{Args, CommandFactory};
use clap_complete::Shell;
use shatter_proto::{Error, ErrorKind};
use std::path::PathBuf;

/// Options of the hidden command `manuals`.
#[derive(Args)]
pub struct ManualsArgs {
    /// Folder for man pages, and completions of bash, zsh and fish
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl ManualsArgs {
    /// Writes a man page for the program `C` and for each of its commands, and its completions.
    ///
    /// # Errors
    /// `output` at the folder if it cannot be written.
    pub fn run<C: CommandFactory>(&self) -> Result<(), Error> {
        self.write::<C>().map_err(|error| {
            let at = self.out.display().to_string();
            Error::new(ErrorKind::Output, at.clone(), format!("cannot write into {at}: {error}"))
        })
    }

    fn write<C: CommandFactory>(&self) -> std::io::Result<()> {
        std::fs::create_dir_all(&self.out)?;
        let mut command = C::command();
        let name = command.get_name().to_owned();
        clap_mangen::generate_to(command.clone(), &self.out)?;
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
            clap_complete::generate_to(shell, &mut command, &name, &self.out)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Parser, Subcommand};

    /// Breaks things.
    #[derive(Parser)]
    #[command(name = "breaker")]
    struct Cli {
        #[command(subcommand)]
        _command: Command,
    }

    #[derive(Subcommand)]
    enum Command {
        /// Strikes an object.
        Strike,
        /// Writes manuals.
        #[command(hide = true)]
        Manuals(ManualsArgs),
    }

    #[test]
    fn every_command_has_a_page_and_every_shell_its_completions() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new");
        ManualsArgs { out: out.clone() }.run::<Cli>().unwrap();
        for file in ["breaker.1", "breaker-strike.1", "breaker.bash", "_breaker", "breaker.fish"] {
            assert!(out.join(file).is_file(), "{file}");
        }
        let page = std::fs::read_to_string(out.join("breaker.1")).unwrap();
        assert!(page.contains("Strikes an object") && !page.contains("manuals"), "{page}");
        let taken = folder.path().join("file");
        std::fs::write(&taken, "").unwrap();
        let refused = ManualsArgs { out: taken }.run::<Cli>().unwrap_err();
        assert_eq!(refused.kind, ErrorKind::Output);
    }
}
