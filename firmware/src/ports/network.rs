//! The network: the machine's port to it.

use base::ports::{Factors, KeysRecord, Network, NetworkNews, NetworkReport, PasswordRecord, Viewers};
use base::snapshot::Snapshot;
use config::NetworkConfig;

use super::{BoardPorts, Locks};

impl<L: Locks> Network for BoardPorts<L> {
    fn join_network(&mut self, config: &NetworkConfig) -> Result<(), &'static str> {
        self.owned.network.join(config)
    }

    fn network_report(&self) -> Option<NetworkReport> {
        self.owned.network.report()
    }

    fn take_network_news(&mut self) -> Option<NetworkNews> {
        self.owned.network.take_news()
    }

    fn set_password_record(&mut self, record: Option<&[u8]>) -> Result<(), &'static str> {
        self.owned.network.set_record(record)
    }

    fn begin_password(&mut self, password: &[u8]) -> bool {
        self.owned.network.begin_password(password)
    }

    fn take_password_record(&mut self) -> Option<PasswordRecord> {
        self.owned.network.take_record()
    }

    fn take_keys_record(&mut self) -> Option<KeysRecord> {
        self.owned.network.take_keys()
    }

    fn set_keys_record(&mut self, record: &[u8]) {
        self.owned.network.set_keys(record);
    }

    fn tell_kept(&mut self, kept: Result<(), &'static str>) {
        self.owned.network.tell_kept(kept);
    }
}

impl<L: Locks> Viewers for BoardPorts<L> {
    fn wants_snapshot(&self) -> bool {
        self.owned.network.wants_snapshot()
    }

    fn show(&mut self, snapshot: &Snapshot) {
        self.owned.network.told_page().into_iter().for_each(|page| page.show(snapshot));
    }

    fn follows_path(&mut self) -> Option<bool> {
        self.owned.network.page()?.follows_path()
    }

    fn add_to_path(&mut self, at: [f32; 3], lays: bool) {
        self.owned.network.page().into_iter().for_each(|page| page.add_to_path(at, lays));
    }

    fn take_factors(&mut self) -> Option<Factors> {
        self.owned.network.page()?.take_factors()
    }

    fn wants_heights(&self, number: u32) -> bool {
        self.owned.network.wants_heights(number)
    }

    fn show_heights(&mut self, number: u32, row: usize, heights: &[f32]) {
        self.owned.network.page().into_iter().for_each(|page| page.show_heights(number, row, heights));
    }

    fn wants_macro(&mut self) -> Option<u16> {
        self.owned.network.page()?.wants_macro()
    }

    fn show_macro(&mut self, number: u16, shown: Option<(&str, &str)>) {
        self.owned.network.told_page().into_iter().for_each(|page| page.site().show_macro(number, shown));
    }

    fn begin_path(&mut self) {
        self.owned.network.page().into_iter().for_each(|page| page.begin_path());
    }
}
