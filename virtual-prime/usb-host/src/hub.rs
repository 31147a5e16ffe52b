//! The hub driver of a computer at one port: it waits until a connected device has settled, resets the bus,
//! gives an address and reads the descriptors (USB 2.0 sections 9.1.2 and 7.1.7).
//!
//! No call waits: [`Root::run`] carries out the steps that are due. So the hub can stand behind a port that
//! another computer commands over a network, where [`super::desk`] is for a test that commands it itself.

mod enumeration;
mod selection;

#[cfg(test)]
mod tests;

use super::controller::{Controller, Port, PortEvent};
use super::descriptors::{Configuration, DeviceDescriptor};
use super::request::Setup;
use super::transfer::{Completion, Direction, Endpoint, Kind, Outcome, Request, TransferId};
use super::wire::Function;

use self::enumeration::{Question, Reading};
use self::selection::Selection;

const MS: u64 = 1_000_000;
/// Time of debouncing after a connection, section 7.1.7.3.
const DEBOUNCE_NS: u64 = 100 * MS;
/// Duration of a bus reset, and recovery time after it, section 7.1.7.5.
const RESET_NS: u64 = 10 * MS;
const RECOVERY_NS: u64 = 10 * MS;
/// Recovery time after SET_ADDRESS, section 9.2.6.3.
const ADDRESS_NS: u64 = 2 * MS;
/// Number of resets of a device that does not answer properly.
const ATTEMPTS: u8 = 3;
/// Greatest duration of a control transfer, section 9.2.6.1.
const PATIENCE_NS: u64 = 5_000 * MS;
/// Address for the device, which is alone on the bus.
const ADDRESS: u8 = 1;

/// Descriptors that a device has given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Found {
    /// The device's own descriptor.
    pub device: DeviceDescriptor,
    /// Every configuration, in order.
    pub configurations: Vec<Configuration>,
}

/// Event at the port.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum HubEvent {
    /// A device has connected and given its descriptors.
    Found,
    /// The device has gone; every transfer has ended.
    Gone,
    /// A device has connected that cannot be used, with the reason.
    Unusable(String),
}

#[derive(Clone, Debug, PartialEq, Eq)]
enum Stage {
    /// No cable is plugged in.
    Unplugged,
    /// A cable is plugged in without a device.
    Empty,
    /// A device has connected and may still bounce, until this instant.
    Debouncing(u64),
    /// Bus reset, until the port is enabled.
    Resetting,
    /// The device recovers from the reset until this instant.
    Recovering(u64),
    /// A question of the hub's own is under way, with the instant of its time-out.
    Asking(Question, TransferId, u64),
    /// The device takes its address until this instant.
    Addressing(u64),
    /// The port is open for transfers of all drivers.
    Ready,
    /// The device is given up until it goes.
    Unusable,
}

/// Driver of the port.
#[derive(Debug)]
pub struct Hub {
    stage: Stage,
    max_packet0: u16,
    attempts: u8,
    reading: Reading,
    found: Option<Found>,
    selection: Selection,
}

impl Default for Hub {
    fn default() -> Self {
        Self {
            stage: Stage::Unplugged,
            max_packet0: 64,
            attempts: 0,
            reading: Reading::default(),
            found: None,
            selection: Selection::default(),
        }
    }
}

impl Hub {
    /// Whether a cable is plugged in.
    #[must_use]
    pub fn is_plugged(&self) -> bool {
        self.stage != Stage::Unplugged
    }

    /// Whether transfers may be submitted: a device is there and has its address.
    #[must_use]
    pub fn is_ready(&self) -> bool {
        self.stage == Stage::Ready
    }

    /// Returns the device's descriptors, from [`HubEvent::Found`] to [`HubEvent::Gone`].
    #[must_use]
    pub const fn found(&self) -> Option<&Found> {
        self.found.as_ref()
    }

    /// Whether a device is there that cannot be used.
    #[must_use]
    pub fn is_unusable(&self) -> bool {
        self.stage == Stage::Unusable
    }

    /// Returns the value of the selected configuration, 0 for none.
    #[must_use]
    pub const fn configuration_value(&self) -> u8 {
        self.selection.configuration
    }

    /// Returns the selected configuration.
    #[must_use]
    pub fn configuration(&self) -> Option<&Configuration> {
        self.selection.of(self.found.as_ref()?)
    }

    /// Returns an endpoint of the selected configuration by its address, bit 7 for IN; endpoint 0 is always
    /// there.
    #[must_use]
    pub fn endpoint(&self, address: u8) -> Option<Endpoint> {
        if address & 0xF == 0 {
            return Some(self.control_endpoint());
        }
        let mut endpoints = self.selection.endpoints(self.found.as_ref()?);
        endpoints.find(|(_, endpoint)| endpoint.address == address).map(|(_, endpoint)| endpoint.of(ADDRESS))
    }

    /// Returns the endpoints of the selected configuration in its present alternate settings, each with the
    /// number of its interface.
    pub fn endpoints(&self) -> impl Iterator<Item = (u8, super::descriptors::EndpointDescriptor)> + '_ {
        self.found.iter().flat_map(|found| self.selection.endpoints(found))
    }

    const fn control_endpoint(&self) -> Endpoint {
        let device = match self.stage {
            Stage::Asking(Question::Begin | Question::Address, ..) | Stage::Recovering(_) => 0,
            _ => ADDRESS,
        };
        Endpoint { device, number: 0, direction: Direction::Out, kind: Kind::Control, max_packet: self.max_packet0 }
    }
}

/// The hub with the controller and the device at the other end of the cable, at this instant.
pub struct Root<'a, F> {
    /// Driver of the port.
    pub hub: &'a mut Hub,
    /// The host controller's state.
    pub controller: &'a mut Controller,
    /// Device at the other end of the cable.
    pub device: &'a mut F,
    /// Virtual time in nanoseconds.
    pub now_ns: u64,
}

impl<F: Function> Root<'_, F> {
    /// Plugs the cable in.
    pub fn plug(&mut self) {
        if !self.hub.is_plugged() {
            self.controller.plug(self.now_ns, self.device);
            self.hub.stage = Stage::Empty;
        }
    }

    /// Pulls the cable out. Transfers that were under way end as [`Outcome::Gone`]; there is no
    /// [`HubEvent::Gone`].
    pub fn unplug(&mut self) {
        if self.hub.is_plugged() {
            self.controller.unplug(self.now_ns, self.device);
            *self.hub = Hub::default();
        }
    }

    /// Resets the bus, and gives the device its address again. Transfers end as [`Outcome::Gone`], and no
    /// configuration is selected any more.
    pub fn reset(&mut self) {
        if matches!(self.hub.stage, Stage::Ready) {
            self.hub.attempts = 0;
            self.begin_reset();
        }
    }

    fn begin_reset(&mut self) {
        self.controller.reset(self.now_ns, RESET_NS, self.device);
        self.hub.selection = Selection::default();
        self.hub.stage = Stage::Resetting;
    }

    /// Submits a transfer, which ends among the completions of [`Self::run`].
    pub fn submit(&mut self, endpoint: Endpoint, request: Request) -> TransferId {
        self.controller.submit(self.now_ns, endpoint, request)
    }

    /// Cancels a submitted transfer. Returns whether it was still there.
    pub fn cancel(&mut self, id: TransferId) -> bool {
        self.controller.cancel(self.now_ns, id)
    }

    /// Follows a control transfer that has been carried out: its effects on the host's side, as on toggles.
    pub fn follow(&mut self, setup: Setup) {
        let Some(found) = &self.hub.found else { return };
        self.hub.selection.follow(setup, found, ADDRESS, self.controller);
    }

    /// Carries out the steps that are due. Returns the events, and the ended transfers of other drivers.
    pub fn run(&mut self) -> (Vec<HubEvent>, Vec<Completion>) {
        let mut news = Vec::new();
        for event in self.controller.take_events() {
            self.notice(event, &mut news);
        }
        let mut completions = self.controller.take_completions();
        if let Stage::Asking(question, asked, until) = self.hub.stage {
            match completions.iter().position(|one| one.id == asked) {
                Some(place) => {
                    let answer = completions.swap_remove(place);
                    self.hear(question, &answer, &mut news);
                }
                None if self.now_ns >= until => {
                    self.cancel(asked);
                    self.give_up("no answer in time", &mut news);
                }
                None => {}
            }
        }
        self.pass_time();
        completions.sort_by_key(|one| (one.at_ns, one.id));
        (news, completions)
    }

    fn notice(&mut self, event: PortEvent, news: &mut Vec<HubEvent>) {
        match event {
            PortEvent::Connected => {
                self.hub.attempts = 0;
                self.hub.stage = Stage::Debouncing(self.now_ns + DEBOUNCE_NS);
            }
            PortEvent::Disconnected => {
                if self.hub.found.is_some() {
                    news.push(HubEvent::Gone);
                }
                *self.hub = Hub { stage: Stage::Empty, ..Hub::default() };
            }
            PortEvent::Woken(_) => {}
        }
    }

    fn pass_time(&mut self) {
        match self.hub.stage {
            Stage::Debouncing(until) if self.now_ns >= until => self.begin_reset(),
            Stage::Resetting if self.controller.port() == Port::Enabled => {
                self.hub.stage = Stage::Recovering(self.now_ns + RECOVERY_NS);
            }
            Stage::Recovering(until) if self.now_ns >= until => {
                // A device with known descriptors needs an address only.
                let first = if self.hub.found.is_some() { Question::Address } else { Question::Begin };
                self.ask(first);
            }
            Stage::Addressing(until) if self.now_ns >= until => {
                if self.hub.found.is_some() {
                    self.hub.stage = Stage::Ready;
                } else {
                    self.ask(Question::Device);
                }
            }
            _ => {}
        }
    }

    fn ask(&mut self, question: Question) {
        // The request goes to endpoint 0 of address 0 or of the new address, depending on the stage.
        self.hub.stage = Stage::Asking(question, TransferId(0), 0);
        let setup = question.setup(ADDRESS, &self.hub.reading).bytes();
        let id = self.submit(self.hub.control_endpoint(), Request::Control { setup, data: Vec::new() });
        self.hub.stage = Stage::Asking(question, id, self.now_ns + PATIENCE_NS);
    }

    fn hear(&mut self, question: Question, answer: &Completion, news: &mut Vec<HubEvent>) {
        if answer.outcome != Outcome::Done {
            let words = format!("{question:?} ended {:?}", answer.outcome);
            return self.give_up(&words, news);
        }
        match question {
            Question::Begin => match answer.data.get(7) {
                Some(&size @ (8 | 16 | 32 | 64)) => {
                    self.hub.max_packet0 = u16::from(size);
                    self.ask(Question::Address);
                }
                _ => self.give_up("its device descriptor has no packet size for endpoint 0", news),
            },
            Question::Address => self.hub.stage = Stage::Addressing(self.now_ns + ADDRESS_NS),
            Question::Device | Question::Head(_) | Question::Whole(_) => {
                match self.hub.reading.take(question, &answer.data) {
                    Ok(Some(next)) => self.ask(next),
                    Ok(None) => {
                        self.hub.found = Some(std::mem::take(&mut self.hub.reading).found);
                        self.hub.stage = Stage::Ready;
                        news.push(HubEvent::Found);
                    }
                    Err(why) => self.give_up(&why, news),
                }
            }
        }
    }

    /// Resets the device and enumerates again, or leaves it alone after too many attempts.
    fn give_up(&mut self, why: &str, news: &mut Vec<HubEvent>) {
        self.hub.attempts += 1;
        self.hub.reading = Reading::default();
        if self.hub.attempts < ATTEMPTS {
            return self.begin_reset();
        }
        if self.hub.found.take().is_some() {
            news.push(HubEvent::Gone);
        }
        self.hub.stage = Stage::Unusable;
        news.push(HubEvent::Unusable(why.to_owned()));
    }
}
