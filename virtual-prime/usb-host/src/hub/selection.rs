//! The configuration and alternate settings that are in force, and what a request does to them and to the
//! host's data toggles (USB 2.0 sections 9.1.1.5 and 9.4.5).

use std::collections::BTreeMap;

use super::Found;
use crate::controller::Controller;
use crate::descriptors::{Configuration, EndpointDescriptor};
use crate::request::{self, Setup};
use crate::wire::Toggle;

/// Selected configuration and alternate settings.
#[derive(Debug, Default)]
pub struct Selection {
    /// Selected configuration (bConfigurationValue), 0 for none.
    pub configuration: u8,
    /// Alternate settings other than 0, by interface.
    settings: BTreeMap<u8, u8>,
}

impl Selection {
    /// Returns the selected configuration.
    pub fn of<'a>(&self, found: &'a Found) -> Option<&'a Configuration> {
        found.configurations.iter().find(|one| self.configuration != 0 && one.value == self.configuration)
    }

    /// Returns the endpoints in force, with the interface of each.
    pub fn endpoints(&self, found: &Found) -> impl Iterator<Item = (u8, EndpointDescriptor)> {
        let interfaces = self.of(found).map_or(&[][..], |configuration| &configuration.interfaces);
        let setting = |number| self.settings.get(&number).copied().unwrap_or(0);
        let in_force = interfaces.iter().filter(move |one| one.setting == setting(one.number));
        let all: Vec<_> =
            in_force.flat_map(|one| one.endpoints.iter().map(|endpoint| (one.number, *endpoint))).collect();
        all.into_iter()
    }

    /// Follows a request that the device at `address` has carried out.
    pub fn follow(&mut self, setup: Setup, found: &Found, address: u8, controller: &mut Controller) {
        match (setup.kind, setup.request) {
            (request::DEVICE_OUT, request::SET_CONFIGURATION) => {
                self.configuration = setup.value as u8;
                self.settings.clear();
                controller.clear_toggles();
            }
            (request::INTERFACE_OUT, request::SET_INTERFACE) => {
                let number = setup.index as u8;
                self.settings.insert(number, setup.value as u8);
                let restarted: Vec<_> = self.endpoints(found).filter(|(of, _)| *of == number).collect();
                for (_, endpoint) in restarted {
                    controller.set_toggle(endpoint.of(address), Toggle::Data0);
                }
            }
            (request::ENDPOINT_OUT, request::CLEAR_FEATURE) if setup.value == request::ENDPOINT_HALT => {
                let halted = setup.index as u8;
                let cleared = self.endpoints(found).find(|(_, endpoint)| endpoint.address == halted);
                if let Some((_, endpoint)) = cleared {
                    controller.set_toggle(endpoint.of(address), Toggle::Data0);
                }
            }
            _ => {}
        }
    }
}
