//! Settings of a run, and the machine that they describe.

use std::fs;
use std::path::{Path, PathBuf};

use base::sessions::SessionProfile;
use config::{BoardId, MachineConfig};

use super::storage::CardState;
use crate::models::tmc26x::Chip;
use crate::world::TimedFault;

/// Settings of a run.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Folder that is the card; `config.ini` in it is the machine's configuration.
    pub card: PathBuf,
    /// Fault of the card, if any.
    pub card_state: CardState,
    /// Model of the board's driver chips.
    pub chip: Chip,
    /// Faults, and when they happen.
    pub faults: Vec<TimedFault>,
    /// Transports in memory beside the two consoles, whose other ends come and go. Nobody is there at the
    /// start.
    pub visitors: Vec<SessionProfile>,
    /// Configuration that fits the machine as built, when the card's differs.
    pub built_as: Option<String>,
    /// Positions of the motors' carriages at power-on, mm; else as the machine is built.
    pub carriages: Vec<f64>,
    /// Number of block writes after which the power is gone.
    pub writes: Option<u32>,
}

impl Setup {
    /// A healthy board with TMC2590 and this folder as its card.
    #[must_use]
    pub fn new(card: &Path) -> Self {
        Self {
            card: card.to_owned(),
            card_state: CardState::Good,
            chip: Chip::Tmc2590,
            faults: Vec::new(),
            visitors: Vec::new(),
            built_as: None,
            carriages: Vec::new(),
            writes: None,
        }
    }
}

/// Returns the machine that the card's configuration describes, as far as it can be read.
pub(super) fn describe(setup: &Setup) -> (MachineConfig, BoardId) {
    let board_id = match setup.chip {
        Chip::Tmc2590 => BoardId::Prime2590,
        Chip::Tmc2660 => BoardId::Prime2660,
    };
    let text = fs::read(setup.card.join("config.ini")).unwrap_or_default();
    // Faults of the configuration are the machine's to report.
    let (machine, _) = config::parse(&text, board_id, &mut ());
    (machine, board_id)
}
