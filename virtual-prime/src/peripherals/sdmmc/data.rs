//! The data path: blocks between the card and the FIFO or memory, RM0399 section 58.5.5.

use super::*;

impl Sdmmc {
    pub(super) fn enable_data(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.remaining = file.get(Register::Dlenr) & 0x1FF_FFFF;
        self.fifo.clear();
        self.dma_address = file.get(Register::Idmabase0r);
        self.dma_room = (file.get(Register::Idmabsizer) >> 5 & 0xFF) * 32;
        // DTIMER counts bus clocks until the card must have begun.
        let patience = self.clocks(file.get(Register::Dtimer).max(1), file);
        let event = context.schedule(VirtualNanos(context.now().0 + patience));
        self.data = Data::Waiting { event: Some(event) };
        self.follow_data(file, context);
    }

    /// Begins the next block when both the controller and the card are ready for it.
    pub(super) fn follow_data(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if !matches!(self.data, Data::Waiting { .. }) || self.transfer == Transfer::None {
            return;
        }
        let reads = file.get(Register::Dctrl) & DTDIR != 0;
        match (self.transfer, reads) {
            (Transfer::Read, true) => self.begin_receiving(FIRST_BLOCK_NS, file, context),
            (Transfer::Write, false) => self.begin_sending(file, context),
            // Card and controller disagree about the direction: nothing comes, and DTIMER runs out.
            _ => {}
        }
    }

    pub(super) fn begin_receiving(&mut self, access_ns: u64, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let bytes = Self::block_bytes(file).min(self.remaining.max(1));
        let Some(block) = self.card.as_mut().and_then(|card| card.read(bytes as usize)) else {
            // The card has nothing: the controller waits for DTIMER.
            return;
        };
        let words = block.chunks(4).map(|chunk| {
            let mut word = [0; 4];
            word[..chunk.len()].copy_from_slice(chunk);
            u32::from_le_bytes(word)
        });
        let block: VecDeque<u32> = words.collect();
        let first = if Self::dma(file) { bytes } else { bytes.min(HALF_FIFO as u64 * 4) };
        let at = context.now().0 + access_ns + self.block_ns(first, file);
        self.data = Data::Receiving { event: context.schedule(VirtualNanos(at)), block };
    }

    /// A burst, or with DMA the block, has come in.
    pub(super) fn receive(
        &mut self,
        mut block: VecDeque<u32>,
        file: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if Self::dma(file) {
            let words: Vec<u32> = block.drain(..).collect();
            for word in words {
                let Some(address) = self.next_dma_address(file) else {
                    self.end_data(file);
                    return;
                };
                context.write_to(address, Width::W32, u64::from(word), 0);
                self.remaining = self.remaining.saturating_sub(4);
            }
        } else {
            let room = FIFO_WORDS - self.fifo.len();
            let burst = block.len().min(HALF_FIFO);
            if room < burst {
                if file.get(Register::Clkcr) & HWFC_EN == 0 {
                    self.status |= flag::RXOVERR;
                    self.end_data(file);
                    return;
                }
                // Flow control stops the clock; reading the FIFO starts it again.
                let event = context.schedule(VirtualNanos(context.now().0 + self.clocks(64, file)));
                self.data = Data::Receiving { event, block };
                return;
            }
            for word in block.drain(..burst) {
                self.fifo.push_back(word);
                self.remaining = self.remaining.saturating_sub(4);
            }
        }
        if !block.is_empty() {
            let burst = block.len().min(HALF_FIFO) as u64 * 4;
            let at = context.now().0 + self.block_ns(burst, file);
            self.data = Data::Receiving { event: context.schedule(VirtualNanos(at)), block };
        } else if self.remaining > 0 {
            self.data = Data::Waiting { event: None };
            self.begin_receiving(NEXT_BLOCK_NS, file, context);
            if matches!(self.data, Data::Waiting { .. }) {
                self.status |= flag::DTIMEOUT;
                self.end_data(file);
            }
        } else {
            self.status |= flag::DATAEND;
            self.end_data(file);
        }
    }

    pub(super) fn begin_sending(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let bytes = Self::block_bytes(file).min(self.remaining.max(1));
        let at = context.now().0 + self.block_ns(bytes.min(HALF_FIFO as u64 * 4), file);
        let event = context.schedule(VirtualNanos(at));
        if Self::dma(file) {
            for word in 0..bytes / 4 {
                let Some(address) = self.next_dma_address(file) else {
                    self.end_data(file);
                    return;
                };
                // The answers come back in order and fill the block.
                context.read_from(address, Width::W32, word);
            }
        }
        self.data = Data::Sending { event, block: Vec::with_capacity(bytes as usize) };
    }

    /// A burst has gone out of the FIFO, or with DMA been fetched.
    pub(super) fn send(&mut self, mut block: Vec<u8>, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let bytes = Self::block_bytes(file).min(self.remaining.max(1)) as usize;
        while block.len() < bytes {
            let Some(word) = self.fifo.pop_front() else { break };
            block.extend(word.to_le_bytes());
        }
        if block.len() < bytes {
            // The FIFO is empty in mid-block: flow control waits, otherwise it is an underrun. Before the first word
            // the controller waits in any case (Wait_S).
            if block.is_empty() || file.get(Register::Clkcr) & HWFC_EN != 0 || Self::dma(file) {
                let event = context.schedule(VirtualNanos(context.now().0 + self.block_ns(32, file)));
                self.data = Data::Sending { event, block };
            } else {
                self.status |= flag::TXUNDERR;
                self.end_data(file);
            }
            return;
        }
        self.remaining = self.remaining.saturating_sub(bytes as u64);
        let sent_ns = context.now().0 + self.block_ns(bytes as u64, file);
        let taken = self.card.as_mut().is_some_and(|card| card.write(sent_ns, &block));
        if !taken {
            self.status |= flag::DCRCFAIL;
            self.end_data(file);
            return;
        }
        let ready_ns = self.card.as_ref().map_or(sent_ns, SdCard::busy_until_ns);
        self.data = Data::Busy { event: context.schedule(VirtualNanos(ready_ns)) };
    }

    pub(super) fn sent(&mut self, file: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        if self.remaining == 0 {
            self.status |= flag::DATAEND;
            self.end_data(file);
        } else {
            self.begin_sending(file, context);
        }
    }

    pub(super) fn end_data(&mut self, file: &mut RegisterFile) {
        self.data = Data::Idle;
        self.transfer = Transfer::None;
        let control = file.get(Register::Dctrl);
        if file.get(Register::Cmdr) & DTHOLD != 0 {
            self.status |= flag::DHOLD;
        }
        file.set(Register::Dctrl, control & !DTEN);
    }

    /// Where the internal DMA goes next; in double-buffer mode it changes buffers and says so.
    pub(super) fn next_dma_address(&mut self, file: &mut RegisterFile) -> Option<u64> {
        let control = file.get(Register::Idmactrlr);
        if control & IDMABMODE != 0 && self.dma_room == 0 {
            let second = control & IDMABACT == 0;
            file.set(Register::Idmactrlr, control ^ IDMABACT);
            self.dma_address = file.get(if second { Register::Idmabase1r } else { Register::Idmabase0r });
            self.dma_room = (file.get(Register::Idmabsizer) >> 5 & 0xFF) * 32;
            self.status |= flag::IDMABTC;
        }
        let address = self.dma_address;
        if !IDMA_REACH.iter().any(|range| range.contains(&address)) {
            self.status |= flag::IDMATE;
            return None;
        }
        self.dma_address += 4;
        self.dma_room = self.dma_room.saturating_sub(4);
        Some(address)
    }
}
