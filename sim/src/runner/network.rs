//! The network as the native runner has it: no frames, but everything that the machine's port says. Scenarios
//! give it news; passwords are kept as they are, behind a word that says so.

use std::collections::VecDeque;

use base::ports::{
    AddressOrigin, Factors, KeysRecord, NetworkAddress, NetworkNews, NetworkReport, NetworkService, PasswordRecord,
};
use base::snapshot::Snapshot;
use config::NetworkConfig;

/// First word of a record here, where a real one has the name of its function.
const SCHEME: &[u8] = b"plain$";

/// State of the network.
#[derive(Debug, Default)]
pub struct SimulatedNetwork {
    /// The report, once the machine has joined.
    pub report: Option<NetworkReport>,
    /// Changes that the machine has not taken yet.
    pub news: VecDeque<NetworkNews>,
    /// The password that is in force.
    pub password: Option<Vec<u8>>,
    /// Record of the keys that are in force.
    pub keys: Option<Vec<u8>>,
    /// Record of keys that a visitor has changed.
    pub changed_keys: Option<KeysRecord>,
    /// Outcomes of keeping what visitors have changed.
    pub kept: Vec<Result<(), &'static str>>,
    /// Whether somebody looks at the machine.
    pub is_viewed: bool,
    /// The machine as it was last shown.
    pub shown: Option<Snapshot>,
    /// Heights of the bed as they were last shown, row by row, and their number.
    pub heights: (u32, Vec<Vec<f32>>),
    /// Whether a viewer wants the macros.
    pub wants_macros: bool,
    /// Macros that were told since: names, and what they say of themselves.
    pub macros: Vec<(String, String)>,
    /// Operator's factors that a viewer wants.
    pub factors: Option<Factors>,
    /// Whether somebody draws the path, or just does not any more; and the path since the last job began.
    pub draws: Option<bool>,
    /// Places of the path: X, Y, Z, and whether material was laid or cut on the way there.
    pub path: Vec<([f32; 3], bool)>,
    /// Record that is made, and the number of questions until it is ready.
    making: Option<(Vec<u8>, u8)>,
}

impl SimulatedNetwork {
    pub(super) fn join(&mut self, config: &NetworkConfig) {
        let consoles = [
            ("Telnet", config.shell, config.shell_port),
            ("GRBL", config.grbl, config.grbl_port),
            ("Page", config.web, config.web_port),
        ];
        let offered = consoles.into_iter().filter(|(_, is_on, _)| *is_on);
        let address = config.address.given().map(|address| NetworkAddress {
            address,
            mask_bits: config.mask_bits().unwrap_or(0),
            gateway: config.gateway.given(),
            dns: config.dns.given(),
            origin: AddressOrigin::Configuration,
        });
        self.report = Some(NetworkReport {
            mac: [2, 0, 0, 0, 0, 1],
            address,
            name: if config.mdns {
                config.host_name.as_str().try_into().unwrap_or_default()
            } else {
                Default::default()
            },
            services: offered.map(|(name, _, port)| NetworkService { name, port, peers: 0 }).collect(),
            ..NetworkReport::default()
        });
    }

    pub(super) fn told(&self) -> Option<NetworkReport> {
        let has_password = self.password.is_some();
        self.report.clone().map(|report| NetworkReport { has_password, ..report })
    }

    pub(super) fn set_record(&mut self, record: Option<&[u8]>) -> Result<(), &'static str> {
        self.password = match record {
            Some(record) => Some(record.strip_prefix(SCHEME).ok_or("this is no record of a password")?.to_vec()),
            None => None,
        };
        Ok(())
    }

    /// Makes the record of a password, as if a visitor had set it, which is ready at once.
    pub fn begin(&mut self, password: &str) -> bool {
        self.making = self.report.as_ref().map(|_| ([SCHEME, password.as_bytes()].concat(), 0));
        self.making.is_some()
    }

    pub(super) fn begin_password(&mut self, password: &[u8]) -> bool {
        self.making = self.report.as_ref().map(|_| ([SCHEME, password].concat(), 3));
        self.making.is_some()
    }

    pub(super) fn take_record(&mut self) -> Option<PasswordRecord> {
        let (record, turns) = self.making.take()?;
        if turns == 0 {
            return PasswordRecord::from_slice(&record).ok();
        }
        self.making = Some((record, turns - 1));
        None
    }
}
