//! Answers of the core to the host's tokens, RM0399 section 60.15 ("Device programming model").

use super::core::Core;
use super::registers::*;
use usb_host::wire::{Address, Drive, Function, Handshake, Reply, Toggle};

/// Number of SETUP packets in a row that a control endpoint keeps.
const BACK_TO_BACK: u32 = 3;

impl Core {
    /// Whether the core receives the traffic for this device at all.
    fn hears(&mut self, to: Address) -> bool {
        to.device == self.address && usize::from(to.endpoint) < ENDPOINTS && self.can_talk()
    }

    /// Ends the SETUP stage, at the first token after SETUP packets: an entry of its own in the receive FIFO.
    fn end_setup_stage(&mut self) {
        if std::mem::take(&mut self.control.setups) > 0 {
            self.receive(rxsts::SETUP_DONE, 0, Toggle::Data0, &[]);
            self.ending[0] = true;
        }
    }

    /// Ends the control transfer after its status stage.
    const fn end_control(&mut self) {
        self.control.open = false;
        self.take_address();
    }

    fn refuse_out(&mut self, number: usize) -> Handshake {
        self.outs[number].raise(epint::NAK);
        Handshake::Nak
    }

    /// Takes an OUT packet with the right toggle, for which there is room.
    fn take(&mut self, number: usize, toggle: Toggle, data: &[u8]) {
        self.receive(rxsts::OUT_DATA, number, toggle, data);
        let max_packet = self.out_max_packet(number);
        let endpoint = &mut self.outs[number];
        endpoint.toggle = toggle.flipped();
        endpoint.packets = endpoint.packets.saturating_sub(1);
        self.control.written |= number == 0 && !data.is_empty();
        // The manual says: "When the packet count becomes 0 or a short packet is received, the NAK bit is
        // set."
        if endpoint.packets == 0 || data.len() < max_packet {
            endpoint.nak = true;
            self.ending[number] = true;
            self.receive(rxsts::OUT_DONE, number, Toggle::Data0, &[]);
        }
        if number == 0 && self.control.reads {
            self.end_control();
        }
    }

    fn out_max_packet(&self, number: usize) -> usize {
        if number == 0 { self.ins[0].max_packet(0) } else { self.outs[number].max_packet(number) }
    }

    /// Returns the next packet to send, if there is one.
    fn next_packet(&self, number: usize) -> Option<Vec<u8>> {
        let endpoint = &self.ins[number];
        let ready = endpoint.enabled && !endpoint.nak && !self.global_in_nak && endpoint.packets > 0;
        let fifo = self.tx.get(endpoint.fifo()).filter(|_| ready)?;
        match fifo.front() {
            Some(packet) => Some(packet.clone()),
            // No more data are to come into the FIFO, so the packet has none.
            None if endpoint.size == 0 && !fifo.is_midway() => Some(Vec::new()),
            None => None,
        }
    }
}

impl Function for Core {
    fn pulls_up(&self) -> bool {
        self.is_connected()
    }

    fn wakes(&self) -> bool {
        self.dctl & dctl::RWUSIG != 0 && self.is_connected()
    }

    fn port(&mut self, now_ns: u64, drive: Drive) {
        self.advance(now_ns);
        self.follow_port(drive);
    }

    fn start_of_frame(&mut self, now_ns: u64, number: u16) {
        self.advance(now_ns);
        if self.can_talk() {
            self.link.set_frame(number);
            self.latched |= gint::SOF;
        }
    }

    fn setup(&mut self, to: Address, packet: [u8; 8]) -> Handshake {
        if to.endpoint != 0 || !self.hears(to) {
            return Handshake::Nothing;
        }
        self.control.open = true;
        self.control.setups += 1;
        self.control.reads = packet[0] & 0x80 != 0 && packet[6..] != [0, 0];
        self.control.written = false;
        self.receive(rxsts::SETUP_DATA, 0, Toggle::Data0, &packet);
        self.ins[0].begin_control();
        self.outs[0].begin_control();
        self.outs[0].count = self.outs[0].count.saturating_sub(1);
        if self.control.setups > BACK_TO_BACK {
            self.outs[0].raise(epint::B2BSTUP);
        }
        Handshake::Ack
    }

    fn out(&mut self, to: Address, toggle: Toggle, data: &[u8]) -> Handshake {
        let number = usize::from(to.endpoint);
        if !self.hears(to) || !self.outs[number].is_active(number) {
            return Handshake::Nothing;
        }
        if number == 0 {
            self.end_setup_stage();
        }
        let status_data = number == 0 && self.control.reads && !data.is_empty();
        let endpoint = &mut self.outs[number];
        if endpoint.is_stalled() || status_data && self.dcfg & dcfg::NZLSOHSK != 0 {
            return Handshake::Stall;
        }
        if !endpoint.enabled {
            endpoint.raise(epint::OTEPDIS);
            return self.refuse_out(number);
        }
        if endpoint.nak || self.global_out_nak {
            return self.refuse_out(number);
        }
        if data.len() > self.out_max_packet(number) {
            self.outs[number].raise(epint::BERR);
            return Handshake::Nothing;
        }
        if toggle != self.outs[number].toggle {
            // The host has missed our handshake and repeats the packet that we have.
            return Handshake::Ack;
        }
        if !self.can_receive(data.len()) {
            return self.refuse_out(number);
        }
        self.take(number, toggle, data);
        Handshake::Ack
    }

    fn poll(&mut self, from: Address) -> Reply {
        let number = usize::from(from.endpoint);
        if !self.hears(from) || !self.ins[number].is_active(number) {
            return Reply::Nothing;
        }
        if number == 0 {
            self.end_setup_stage();
            if std::mem::take(&mut self.control.written) {
                self.outs[0].raise(epint::STSPHSRX);
            }
        }
        if self.ins[number].is_stalled() {
            return Reply::Stall;
        }
        if let Some(packet) = self.next_packet(number) {
            return Reply::Data(self.ins[number].toggle, packet);
        }
        let empty = self.tx.get(self.ins[number].fifo()).is_some_and(|fifo| fifo.front().is_none());
        self.ins[number].raise(epint::NAK | if empty { epint::ITTXFE } else { 0 });
        Reply::Nak
    }

    fn acknowledge(&mut self, from: Address) {
        let number = usize::from(from.endpoint);
        let Some(packet) = self.next_packet(number) else { return };
        let endpoint = &mut self.ins[number];
        if !packet.is_empty() {
            self.tx[endpoint.fifo()].pop();
        }
        endpoint.toggle = endpoint.toggle.flipped();
        endpoint.packets -= 1;
        if endpoint.packets == 0 {
            endpoint.enabled = false;
            endpoint.raise(epint::XFRC);
        }
        if number == 0 && !self.control.reads {
            self.end_control();
        }
    }

    fn stirred(&mut self) -> bool {
        std::mem::take(&mut self.stirred)
    }
}
