//! Announcements of the device to a usbredir peer: at its connection, and when its selected configuration
//! changes.

use super::message::{DeviceInfo, EndpointInfo, FULL_SPEED, InterfaceInfo, Message, PLACES, place};
use crate::descriptors::Configuration;
use crate::hub::{Found, Hub};
use crate::request::{self, Setup};

/// Announces a connected device: its interfaces, its endpoints and device_connect, in this order.
pub fn device(found: &Found, hub: &Hub) -> [Message; 3] {
    // Nothing is selected yet, but the peer judges the device by its interfaces, so those of the first
    // configuration are announced.
    let first = found.configurations.first();
    let connect = Message::DeviceConnect(DeviceInfo {
        speed: FULL_SPEED,
        class: found.device.class,
        vendor: found.device.vendor,
        product: found.device.product,
        release: found.device.release,
    });
    [interfaces(hub.configuration().or(first)), endpoints(hub), connect]
}

/// Announces the result of a selecting request, as far as the peer has to know it before the answer.
pub fn selection(setup: Setup, hub: &Hub) -> Vec<Message> {
    match (setup.kind, setup.request) {
        (request::DEVICE_OUT, request::SET_CONFIGURATION) => vec![interfaces(hub.configuration()), endpoints(hub)],
        (request::INTERFACE_OUT, request::SET_INTERFACE) => vec![endpoints(hub)],
        _ => Vec::new(),
    }
}

fn interfaces(configuration: Option<&Configuration>) -> Message {
    let all = configuration.map_or(&[][..], |configuration| &configuration.interfaces);
    let first_settings = all.iter().filter(|one| one.setting == 0);
    Message::InterfaceInfo(first_settings.map(|one| InterfaceInfo { number: one.number, class: one.class }).collect())
}

fn endpoints(hub: &Hub) -> Message {
    let max_packet = hub.endpoint(0).map_or(0, |endpoint| endpoint.max_packet);
    let control = EndpointInfo { kind: 0, interval: 0, interface: 0, max_packet };
    let mut places = Box::new([EndpointInfo::NONE; PLACES]);
    (places[place(0)], places[place(0x80)]) = (control, control);
    for (interface, endpoint) in hub.endpoints() {
        places[place(endpoint.address)] = EndpointInfo {
            kind: endpoint.attributes & 3,
            interval: endpoint.of(0).frames() as u8,
            interface,
            max_packet: endpoint.max_packet,
        };
    }
    Message::EpInfo(places)
}
