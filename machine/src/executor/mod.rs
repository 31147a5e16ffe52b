//! The executor: the one loop over the whole machine. It takes lines from sessions, files and scripts, has
//! the program say what they mean, carries that out, waits where it must, and serves everybody at each
//! waiting point.
//!
//! Nothing outside this folder sees the whole machine. Sequences that take time are handed [`Hands`];
//! everything else gets the owners it needs as arguments.

mod actions;
mod answers;
mod automatic;
mod axis_tests;
mod blocks;
mod boot;
mod brown_out;
mod card;
mod commands;
mod cut;
mod disk;
mod door;
mod editing;
mod fast_forward;
mod filament;
mod flow;
mod foresee;
mod frames;
mod functions;
mod grbl;
mod halt;
mod hands;
mod hold;
mod holes;
mod home;
mod job_control;
mod journal;
mod kept;
mod leave_out;
mod lights;
mod line_numbers;
mod lines;
mod log;
mod long_answers;
mod machine;
mod motion_tests;
mod named;
mod objects;
mod operator;
mod passed;
mod passed_over;
mod play_from;
mod polls;
mod probe_script;
mod program_io;
mod recorded;
mod recording;
mod recover;
mod restore;
mod serve;
mod shapes;
mod source;
mod stack;
mod stall_recovery;
mod stalls;
mod statistics;
mod suspend;
mod tool_change;
mod update;
mod update_watch;

use core::pin::pin;

pub use hands::Hands;
pub(crate) use line_numbers::decoder_expecting;
use machine::Machine;

use crate::forecast::{self, Foresight};
use crate::ports::Ports;
use crate::sessions::Sessions;
use crate::wait::yield_once;

/// So many lines at most are carried out before everybody is served: most take ten microseconds or two.
const LINES_IN_A_ROW: u8 = 4;

/// Boots and serves, for ever. The board polls this in `idle`, the host runner in virtual time; it yields at
/// every wait.
pub async fn run<P: Ports>(mut ports: P) -> ! {
    let mut config = boot::unread();
    let mut sessions = Sessions::new();
    let read = boot::read_config(&mut ports, &mut sessions, &mut config).await;
    let mut workspace = ports.workspace();
    let foresight = Foresight::new(&config, workspace.as_deref_mut());
    let mut machine = Machine::new(ports, &config, &mut sessions, read.took, &foresight, serve::serve);
    let executor = pin!(run_machine(&mut machine, read));
    forecast::beside(executor, &foresight).await
}

async fn run_machine<P: Ports>(machine: &mut Machine<'_, P>, read: boot::Read) -> ! {
    // Pinned, it is a function of its own, and the loop below is short.
    pin!(boot::start(machine, read)).await;
    loop {
        machine.serve();
        let mut has_run = 0;
        while has_run < LINES_IN_A_ROW && pin!(lines::run_next(machine)).await {
            has_run += 1;
        }
        if has_run == 0 && !(machine.update.waits() && pin!(update::run_next(machine)).await) {
            machine.ports.rest();
            yield_once().await;
        }
    }
}
