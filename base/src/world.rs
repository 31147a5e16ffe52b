//! The world as one machine sees it: all ports together.

use core::fmt::Arguments;

use config::MachineConfig;
use events::Event;

use crate::failure::{Failure, Texts};
use crate::ports::{
    Ahead, Board, Calendar, Clock, DriversPort, EventLog, HeatPort, Inputs, LaserPort, LightPort, MotionPort, Network,
    PinPort, Rest, Storage, Updates, Usb, Viewers,
};
use crate::sessions::{ConsoleKind, Consoles, Recipient, Reply, Rights, Session, Sessions};
use crate::supervisor::SupervisorPort;

/// All that one machine asks of the world.
pub trait Ports:
    Clock
    + Rest
    + MotionPort
    + Ahead
    + HeatPort
    + LightPort
    + LaserPort
    + DriversPort
    + SupervisorPort
    + Inputs
    + PinPort
    + Storage
    + Consoles
    + Board
    + Usb
    + Network
    + Calendar
    + EventLog
    + Updates
    + Viewers
{
}

impl<P> Ports for P where
    P: Clock
        + Rest
        + MotionPort
        + Ahead
        + HeatPort
        + LightPort
        + LaserPort
        + DriversPort
        + SupervisorPort
        + Inputs
        + PinPort
        + Storage
        + Consoles
        + Board
        + Usb
        + Network
        + Calendar
        + EventLog
        + Updates
        + Viewers
{
}

/// The world around the machine's parts: what it reaches through ports, how it is configured, and who hears
/// of it.
pub struct World<'c, P> {
    /// The world, as one machine sees it.
    pub ports: P,
    /// Configuration as it was read.
    pub config: &'c MachineConfig,
    /// Texts of failure messages.
    pub texts: &'c Texts,
    /// Sessions, which hear what is said.
    pub sessions: &'c mut Sessions,
}

impl<P: Ports> World<'_, P> {
    /// Says something to one recipient.
    pub fn say(&mut self, to: Recipient, text: Arguments<'_>) {
        self.sessions.say(to, text);
    }

    /// Says something to every session.
    pub fn announce(&mut self, text: Arguments<'_>) {
        self.sessions.say(Recipient::All, text);
    }

    /// Says a text where only who stands at the machine reads it: on every console but those of the network.
    pub fn tell_at_machine(&mut self, text: Arguments<'_>) {
        let Self { sessions, ports, .. } = self;
        for id in sessions.ids() {
            let is_there = !matches!(ports.profile(id).kind, ConsoleKind::Network | ConsoleKind::Web);
            if let Some(session) = sessions.get_mut(id).filter(|_| is_there) {
                session.announce(text);
            }
        }
    }

    /// Checks that whoever asks may send more lines that are no commands: of a file. Visitors of the page
    /// share a session, so the next line may be somebody else's.
    ///
    /// # Errors
    /// For a session that is shared.
    pub fn sends_alone(&self, asked: Recipient) -> Result<(), Failure> {
        let session = asked.session().and_then(|id| self.sessions.get(id));
        if session.is_some_and(Session::is_shared) {
            return Err(Failure::refused(&"visitors of the page share this console: upload the file on the page"));
        }
        Ok(())
    }

    /// Checks that whoever asks may change files, settings and firmware. `job` is what lines of the job may
    /// do: they are those that no session asks for.
    ///
    /// # Errors
    /// For a session that may only have the machine work, and for the job of one.
    pub fn owner_only(&self, asked: Recipient, job: Rights) -> Result<(), Failure> {
        let rights = if asked.session().is_some() { self.sessions.rights_of(asked) } else { job };
        if rights >= Rights::Own {
            return Ok(());
        }
        Err(Failure::refused(
            &"this is for who has the machine's password: log in with it, or use USB or a serial console",
        ))
    }

    /// Refuses a recipient's request, with the text of a failure.
    pub fn refuse(&mut self, to: Recipient, why: Failure) {
        self.sessions.refuse(to, why.reason, format_args!("{}", self.texts.of(why)));
    }

    /// Returns an answer to one recipient, to be said piece by piece.
    pub fn reply(&mut self, to: Recipient) -> Reply<'_> {
        Reply::new(self.sessions, to)
    }

    /// Keeps an event, in the ring that survives a reset.
    pub fn record(&self, event: &Event) {
        self.ports.events().record(self.ports.now(), event);
    }
}
