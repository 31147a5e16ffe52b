//! The board and the machine on it, as the command line describes them.

use std::fs;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use config::{BoardId, Diagnostic};
use sim::models::tmc26x::Chip;
use sim::world::{SPELLING, TimedFault, WorldConfig};
use virtual_prime::board::PrimeBoard;
use virtual_prime::sd_image;

/// Which driver chips the board carries.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub enum Drivers {
    /// Board id 0.
    #[default]
    Tmc2590,
    /// Board id 1.
    Tmc2660,
}

/// The image, the board that runs it, its card and its machine.
#[derive(Args, Debug)]
pub struct BoardOptions {
    /// The firmware image.
    #[arg(long)]
    pub elf: PathBuf,
    /// Driver chips on the board.
    #[arg(long, value_enum, default_value_t)]
    pub board: Drivers,
    /// Configuration file; the simulated machine is the one it describes, and it goes onto the SD card as
    /// config.ini.
    #[arg(long)]
    pub config: Option<PathBuf>,
    /// Directory whose files go onto the SD card as well.
    #[arg(long)]
    pub sd: Option<PathBuf>,
    /// What goes wrong, and when.
    #[arg(long, long_help = SPELLING)]
    pub fault: Vec<String>,
}

impl BoardOptions {
    const fn chip(&self) -> Chip {
        match self.board {
            Drivers::Tmc2590 => Chip::Tmc2590,
            Drivers::Tmc2660 => Chip::Tmc2660,
        }
    }

    /// Builds the machine of the configuration. Mistakes in the configuration are told on standard error and
    /// left to the firmware from then on.
    fn machine(&self) -> Result<WorldConfig, String> {
        let Some(path) = &self.config else {
            return Ok(WorldConfig { chip: self.chip(), ..WorldConfig::default() });
        };
        let text = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let id = match self.board {
            Drivers::Tmc2590 => BoardId::Prime2590,
            Drivers::Tmc2660 => BoardId::Prime2660,
        };
        let mut findings: Vec<Diagnostic> = Vec::new();
        let (machine, _) = config::parse(&text, id, &mut findings);
        for finding in findings {
            eprintln!("{}: {finding}", path.display());
        }
        Ok(WorldConfig::of(&machine, self.chip()))
    }

    /// Returns the configuration as a file for the SD card.
    fn config_file(&self) -> Result<Option<sd_image::File>, String> {
        let Some(path) = &self.config else { return Ok(None) };
        let text = fs::read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Some(("config.ini".into(), text)))
    }

    /// Builds the board at power-on, with these files and those of the command line on its card.
    ///
    /// # Errors
    /// What is wrong with the configuration file, the card's files or the faults.
    pub fn build(&self, mut files: Vec<sd_image::File>) -> Result<PrimeBoard, String> {
        files.extend(self.config_file()?);
        let mut board = PrimeBoard::new(self.machine()?).map_err(|error| error.to_string())?;
        for text in &self.fault {
            board.world().lock().schedule(TimedFault::parse(text)?)?;
        }
        board.insert_card(Some(sd_image::build(self.sd.as_deref(), &files)?));
        Ok(board)
    }
}
