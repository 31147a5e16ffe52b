//! Consoles of the board: an enum, so that a new console makes the compiler name every place that must
//! change.

use base::sessions::{ConsoleKind, Rights, SessionProfile};
use base::sessions::{INBOX_BYTES, Inbox, InboxOf, NETWORK_INBOX_BYTES, SessionId};
use gcode::Dialect;
use net::{LINES, Service};

static DEBUG: InboxOf<INBOX_BYTES> = InboxOf::new();
static UART0: InboxOf<INBOX_BYTES> = InboxOf::new();
static UART1: InboxOf<INBOX_BYTES> = InboxOf::new();
// The bus carries 64 bytes at a time, so these inboxes may lie in slower memory.
#[unsafe(link_section = ".d2ram")]
static USB0: InboxOf<INBOX_BYTES> = InboxOf::new();
#[unsafe(link_section = ".d2ram")]
static USB1: InboxOf<INBOX_BYTES> = InboxOf::new();
/// Nothing fast reads this inbox, so it need not be in DTCM; and it is all zero, as the section is.
#[unsafe(link_section = ".d2ram")]
static RTT: InboxOf<INBOX_BYTES> = InboxOf::new();

/// Inboxes of network consoles, whose bytes come in packets as well.
#[unsafe(link_section = ".d2ram")]
static NETWORK: [InboxOf<NETWORK_INBOX_BYTES>; LINES] = [const { InboxOf::new() }; LINES];
/// Inbox of the page's console, which gets a line at a time.
#[unsafe(link_section = ".axisram")]
static PAGE: InboxOf<NETWORK_INBOX_BYTES> = InboxOf::new();

/// A console, in the order of the session ids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Console {
    /// USART2, the debug UART.
    Debug,
    /// USART3, UART 0 of the configuration.
    Uart0,
    /// UART4, UART 1 of the configuration.
    Uart1,
    /// The first serial port at the USB socket.
    Usb0,
    /// The second one, if the configuration has one.
    Usb1,
    /// RTT, through a debug probe.
    Rtt,
    /// A console of the network, by its number: two for Telnet, then two in GRBL's dialect.
    Network(u8),
    /// The console of the page.
    Page,
}

impl Console {
    /// All consoles of the board.
    pub const ALL: [Self; 11] = [
        Self::Debug,
        Self::Uart0,
        Self::Uart1,
        Self::Usb0,
        Self::Usb1,
        Self::Rtt,
        Self::Network(0),
        Self::Network(1),
        Self::Network(2),
        Self::Network(3),
        Self::Page,
    ];

    /// Returns the console of a session.
    pub fn of(session: SessionId) -> Option<Self> {
        Self::ALL.get(usize::from(session.0)).copied()
    }

    /// Returns the queue of received bytes.
    pub const fn inbox(self) -> &'static Inbox {
        match self {
            Self::Debug => &DEBUG,
            Self::Uart0 => &UART0,
            Self::Uart1 => &UART1,
            Self::Usb0 => &USB0,
            Self::Usb1 => &USB1,
            Self::Rtt => &RTT,
            Self::Network(place) => &NETWORK[place as usize % LINES],
            Self::Page => &PAGE,
        }
    }

    /// Returns the kind of peer at the other end.
    pub const fn profile(self) -> SessionProfile {
        match self {
            Self::Debug | Self::Uart0 | Self::Uart1 => SessionProfile::SERIAL,
            Self::Usb0 | Self::Usb1 => SessionProfile { kind: ConsoleKind::Usb, ..SessionProfile::SERIAL },
            // The visitor's rights are known to the network.
            Self::Network(place) => SessionProfile {
                kind: ConsoleKind::Network,
                rights: Rights::Watch,
                dialect: match net::service_of(place as usize) {
                    Service::Telnet => None,
                    Service::Grbl => Some(Dialect::Grbl),
                },
                ..SessionProfile::SERIAL
            },
            // Rights are those that the network gives to visitors of the page.
            Self::Page => {
                SessionProfile { kind: ConsoleKind::Web, rights: Rights::Watch, greeting: "", ..SessionProfile::SERIAL }
            }
            Self::Rtt => SessionProfile { kind: ConsoleKind::Memory, ..SessionProfile::SERIAL },
        }
    }
}
