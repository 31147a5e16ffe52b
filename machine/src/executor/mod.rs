//! The executor: the one loop over the whole machine, which takes lines from sessions, files and scripts, has
//! the program say what they mean, carries that out, waits where it must, and serves everybody at each
//! waiting point.
//!
//! Only the loop, and the tables that lead functions and commands to their owners, see the whole machine.
//! Features and services take the small traits of [`crate::machine::work_hands`], sequences of other crates
//! [`crate::machine::hands::MachineHands`], and everything else the owners it needs.

pub(crate) mod actions;
pub(crate) mod answers;
pub(crate) mod blocks;
pub(crate) mod boot;
pub(crate) mod bore_retract;
pub(crate) mod dry_run;
pub(crate) mod lines;
pub(crate) mod named_commands;
pub(crate) mod out_of_turn;
pub(crate) mod program_flow;
pub(crate) mod serve;
pub(crate) mod stack;
pub(crate) mod tool_change;

use core::cell::RefCell;
use core::convert::Infallible;
use core::pin::pin;

use crate::machine::Machine;
use crate::machine::moments::{Features, Moments as _};
use config::MachineConfig;
use units::Micros;

use base::Ports;
use base::failure::Texts;
use base::own_frame::apart;
use base::ports::Wake;
use base::sessions::Sessions;
use preflight::forecast::{Desk, SharedForecast, Work, read_file};
use printer_cfg::Memory;

/// Time of carrying out lines after which everybody is served: most lines take ten microseconds or two.
const SERVE_AFTER: Micros = Micros(50);
/// Number of lines after which everybody is served: a host's clock may stand still meanwhile.
const LINES_IN_A_ROW: u8 = 16;

/// State of the executor beside its stack, for as long as it runs. Large: the caller of [`run`] says where it
/// lies.
pub struct Lasting {
    config: MachineConfig,
    texts: Texts,
    sessions: Sessions,
    forecast: SharedForecast,
}

impl Lasting {
    /// Makes the state before anything has been read or said.
    #[must_use]
    #[expect(clippy::new_without_default, reason = "there is one of it")]
    pub fn new() -> Self {
        Self {
            config: MachineConfig::default(),
            texts: Texts::new(),
            sessions: Sessions::new(),
            forecast: SharedForecast::new(),
        }
    }
}

/// Boots and serves, for ever, resting whenever there is nothing to do ([`base::ports::Rest`]).
///
/// `macros`: memory of macros, whose contents are the machine's from then on.
pub fn run<P: Ports>(mut ports: P, lasting: &mut Lasting, macros: Memory<'_>) -> Infallible {
    let Lasting { config, texts, sessions, forecast } = lasting;
    let read = apart(|| boot::read_config(&mut ports, sessions, config));
    let (config, texts, forecast) = (&*config, &*texts, &*forecast);
    let mut workspace = ports.workspace();
    let desk = RefCell::new(workspace.as_deref_mut().map(|workspace| Desk::new(config, texts, workspace)));
    let place = pin!(None);
    let mut forecaster = Work::new(forecast, &desk, || read_file(forecast, &desk), place);
    let mut machine = Machine::new(ports, config, texts, sessions, read.took, macros, (forecast, &mut forecaster));
    apart(|| boot::start(&mut machine, read));
    loop {
        machine.serve();
        let since = machine.world.ports.now();
        if lines::run_next(&mut machine) {
            let mut left = LINES_IN_A_ROW - 1;
            while left > 0 && machine.world.ports.now().since(since) < SERVE_AFTER && lines::run_next(&mut machine) {
                left -= 1;
            }
        } else if !Features::<P>::idle(&mut machine) {
            machine.rest(Wake::Time);
        }
    }
}
