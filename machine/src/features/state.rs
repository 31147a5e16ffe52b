//! State of all features, and the steps of their sequences that wait on the stack of frames.

use base::brown_out::BrownOut;
use base::sessions::Recipient;
use base::snapshot::JobShown;
use base::stall_watch::StallWatch;
use config::MachineConfig;
use jobs::journal::{self, Journal, Recovery};
use parts::fans::Fans;
use parts::filament::{self, Filament};
use parts::laser::Beam;
use parts::lights::LightShow;
use parts::outputs::TemperatureSwitches;
use parts::strips::Strips;
use printer_cfg::Memory;
use procedures::paper::Paper;
use procedures::stall_recovery::StallRecovery;
use program::LightChange;
use thermal::Effects;
use thermal::surplus::SurplusWatch;
use units::Micros;

use super::event_log::recorded::Recorded;
use super::grbl::state::Grbl;
use super::macros::state::Macros;
use super::power_loss::standing::Standing;
use super::stalls::step::Step as StallStep;
use super::update::watch::Watch;

/// State of the features.
pub(crate) struct States<'c> {
    /// State that only GRBL's dialect has.
    pub grbl: Grbl,
    /// State that the ring of events has recorded.
    pub recorded: Recorded,
    /// Time of the next count of heaters' work, for the statistics.
    pub heat_due: Micros,
    /// Watch over falling supplies.
    pub brown_out: BrownOut,
    /// Looks at drivers that report stalls.
    pub stall_watch: StallWatch,
    /// Recovery after a stall has stopped the job.
    pub stalls: StallRecovery,
    /// The paper test that is under way.
    pub paper: Paper,
    /// Fans that run by themselves, and their tachometers.
    pub fans: Fans,
    /// Outputs switched by temperatures.
    pub temperature_switches: TemperatureSwitches,
    /// Watch whether heaters take the power that their models explain.
    pub heat_surplus: SurplusWatch,
    /// Colours that strips of lights are told to have, colours that wait for their places on the path, and
    /// colours shown.
    pub strips: Strips,
    pub riding_lights: Effects<LightChange>,
    pub lights: LightShow,
    /// Lock of the laser, and its beam at rest.
    pub beam: Beam,
    pub filament: Filament,
    pub filament_width: filament::Width,
    /// Journal of the played job on the card.
    pub journal: Journal,
    /// Program's state before the line of a session that is carried out under a job that is noted.
    pub before_session: Option<Standing>,
    /// Job on its way back after a power cut.
    pub recovery: Option<Recovery>,
    /// The last job, as viewers see it.
    pub last_job: Option<JobShown>,
    /// Watch over firmware updates.
    pub update: Watch,
    /// Macros under way, and what they keep.
    pub macros: Macros<'c>,
}

impl<'c> States<'c> {
    /// Makes the state before anything has happened.
    pub fn new(config: &MachineConfig, macros: Memory<'c>) -> Self {
        Self {
            grbl: Grbl::default(),
            recorded: Recorded::default(),
            heat_due: Micros(0),
            brown_out: BrownOut::default(),
            stall_watch: StallWatch::default(),
            stalls: StallRecovery::default(),
            paper: Paper::default(),
            fans: Fans::new(config),
            temperature_switches: TemperatureSwitches::new(config),
            heat_surplus: SurplusWatch::default(),
            strips: Strips::new(),
            riding_lights: Effects::new(),
            lights: LightShow::default(),
            beam: Beam::default(),
            filament: Filament::default(),
            filament_width: filament::Width::new(&config.filament_width),
            journal: Journal::new(config.player.power_loss.enable),
            before_session: None,
            recovery: None,
            last_job: None,
            update: Watch::default(),
            macros: Macros::new(macros),
        }
    }
}

/// Step of a feature's sequence that waits for a script, or for lines read over.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Step {
    /// A job goes on after a power cut; somebody hears of it.
    Recover(journal::Step, Recipient),
    /// A stall has stopped the job.
    Stalled(StallStep),
    /// The lines before the one that a job is to begin with have been read over.
    PlayFrom(Recipient),
    /// Macros under way, above so many others.
    Macros { above: u8 },
}
