//! Analog inputs: ADC1 scans the thermistors for ever into a DMA ring; ADC3 takes one reading of a supply or
//! header input at a time.
//!
//! Nobody waits for a conversion and no interrupt is taken: the ring always holds the last [`AVERAGED`]
//! scans, and heat control averages them when it ticks. Both converters run from per_ck (64 MHz HSI) / 6,
//! halved again inside from silicon revision V on: 5.33 MHz. With 810.5 cycles of sampling (the inputs come
//! through 4.7 kOhm) one conversion takes 154 us, so the ring of four inputs is renewed every 20 ms.
//!
//! Both converters are calibrated for offset and linearity, which takes 31 ms: begun when the board comes up
//! and over long before a configuration has been read. Without linearity, codes are missing near multiples of
//! 4096, and temperatures jump by up to 0.8 K there.

use stm32h7xx_hal::pac;

use crate::dma_buffer;
use crate::pins::table::VBAT;
use crate::wait;

/// Number of scans averaged, as in Smoothieware.
pub const AVERAGED: usize = 32;
/// Greatest number of inputs in a scan.
pub const MAX_INPUTS: usize = 7;
/// Limit of the regulator's start-up, which takes 10 us (DS12923, "ADC characteristics", tADCVREG_STUP); ten
/// times that.
const REGULATOR_LIMIT_US: u32 = 100;
/// Limit of the calibration of offset and linearity, which takes 165,010 ADC cycles (DS12923, "ADC
/// characteristics", tCAL): 31 ms at 5.33 MHz. Three times that.
const CALIBRATION_LIMIT_US: u32 = 100_000;
/// Limit of the enabling, which takes a few cycles of the converter's clock; a hundred times that.
const READY_LIMIT_US: u32 = 100;
/// Longest sampling time, 810.5 cycles (RM0399 section 26.7.7, SMP = 7), for all inputs 0 to 9 of a register
/// at once.
const SLOWEST_SAMPLING: u32 = 0o7_777_777_777;

dma_buffer! {
    /// Ring of scans, as the converter delivers them.
    static RING: [u16; AVERAGED * MAX_INPUTS]
}

/// Failure of an analog-to-digital converter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdcError {
    /// Regulator, calibration or enable of the converter did not report ready in time.
    NotReady,
    /// More than [`MAX_INPUTS`] inputs, none, or one that does not exist.
    BadInputs,
    /// The sample ring is not where a DMA can write it.
    RingMisplaced,
    /// Fewer than [`AVERAGED`] scans have been made yet.
    NotFilled,
    /// The DMA stream stopped, so readings would be stale.
    ScanStopped,
}

/// Powers a converter and begins its calibration, single-ended, of offset and linearity (RM0399 section
/// 26.4.6 to 26.4.8). The converter's clock must be set.
fn begin_calibration(adc: &pac::adc3::RegisterBlock) -> Result<(), AdcError> {
    adc.cr.modify(|_, w| w.deeppwd().clear_bit());
    adc.cr.modify(|_, w| w.advregen().set_bit());
    wait::until(REGULATOR_LIMIT_US, || adc.isr.read().bits() & (1 << 12) != 0).map_err(|_| AdcError::NotReady)?;
    adc.difsel.reset();
    adc.cr.modify(|_, w| w.adcaldif().clear_bit().adcallin().set_bit());
    adc.cr.modify(|_, w| w.adcal().set_bit());
    Ok(())
}

/// Enables a converter once its calibration is over (RM0399 section 26.4.9).
fn enable(adc: &pac::adc3::RegisterBlock) -> Result<(), AdcError> {
    wait::until(CALIBRATION_LIMIT_US, || adc.cr.read().adcal().bit_is_clear()).map_err(|_| AdcError::NotReady)?;
    adc.isr.write(|w| w.adrdy().set_bit());
    adc.cr.modify(|_, w| w.aden().set_bit());
    wait::until(READY_LIMIT_US, || adc.isr.read().adrdy().bit_is_set()).map_err(|_| AdcError::NotReady)?;
    // SAFETY: ten (and ten) three-bit fields, every value of which is a sampling time.
    unsafe {
        adc.smpr1.write(|w| w.bits(SLOWEST_SAMPLING));
        adc.smpr2.write(|w| w.bits(SLOWEST_SAMPLING));
    }
    Ok(())
}

/// Scan of the thermistor inputs, by ADC1.
pub struct Thermistors {
    adc: pac::ADC1,
    dma: pac::DMA1,
    inputs: usize,
    calibration_begun: Result<(), AdcError>,
}

/// DMA1's stream for the scan; the request multiplexer has one channel per stream.
const STREAM: usize = 1;
/// ADC1's request line (RM0399 section 18.3.2, table of DMAMUX1 inputs).
const ADC1_REQUEST: u8 = 9;

impl Thermistors {
    pub(crate) fn new(adc: pac::ADC1, common: &pac::ADC12_COMMON, dma: pac::DMA1) -> Self {
        // RM0399 section 26.8.2: asynchronous clock, divided by 6.
        // SAFETY: 0b0011 is "divided by 6", 0b00 "asynchronous".
        common.ccr.modify(|_, w| unsafe { w.ckmode().bits(0).presc().bits(0b0011) });
        // RM0399 section 13.3.1: PA0_C is a pad of its own when its switch to PA0 is open; it is thermistor
        // input 0. SAFETY: SYSCFG's PMCR is written here alone, once, before any interrupt is enabled.
        unsafe { (*pac::SYSCFG::ptr()).pmcr.modify(|_, w| w.pa0so().set_bit()) };
        let calibration_begun = begin_calibration(&adc);
        Self { adc, dma, inputs: 0, calibration_begun }
    }

    /// Starts the scan of these converter channels in this order. Call once.
    ///
    /// # Errors
    /// [`AdcError`].
    pub fn start(&mut self, channels: &[u8]) -> Result<(), AdcError> {
        if channels.is_empty() || channels.len() > MAX_INPUTS || channels.iter().any(|channel| *channel > 19) {
            return Err(AdcError::BadInputs);
        }
        let ring = RING.address().ok_or(AdcError::RingMisplaced)?;
        self.calibration_begun?;
        enable(&self.adc)?;
        self.set_sequence(channels);
        self.start_dma(ring, channels.len());
        // RM0399 section 26.7.4: 16 bits, continuous, keep the newest on overrun, circular DMA.
        // SAFETY: RES = 0 and DMNGT = 3 are those settings.
        self.adc.cfgr.write(|w| unsafe { w.res().bits(0).cont().set_bit().ovrmod().set_bit().dmngt().bits(0b11) });
        self.adc.cr.modify(|_, w| w.adstart().set_bit());
        self.inputs = channels.len();
        Ok(())
    }

    fn set_sequence(&self, channels: &[u8]) {
        let at = |rank: usize| u32::from(channels.get(rank).copied().unwrap_or(0));
        let select = channels.iter().fold(0, |mask, channel| mask | (1_u32 << channel));
        // RM0399 section 26.7.8 ff.: preselection, then ranks of six bits, four in SQR1 after the length,
        // three (of five) in SQR2. SAFETY: channels are at most 19, the length at most 7: valid fields.
        unsafe {
            self.adc.pcsel.write(|w| w.bits(select));
            let length = channels.len() as u32 - 1;
            self.adc.sqr1.write(|w| w.bits(length | at(0) << 6 | at(1) << 12 | at(2) << 18 | at(3) << 24));
            self.adc.sqr2.write(|w| w.bits(at(4) | at(5) << 6 | at(6) << 12));
        }
    }

    fn start_dma(&self, ring: u32, inputs: usize) {
        // SAFETY: the request multiplexer's channel of this stream is used here alone.
        let mux = unsafe { &*pac::DMAMUX1::ptr() };
        // SAFETY: 9 is ADC1's request line.
        mux.ccr[STREAM].write(|w| unsafe { w.dmareq_id().bits(ADC1_REQUEST) });
        let stream = &self.dma.st[STREAM];
        let source = self.adc.dr.as_ptr() as u32;
        // RM0399 section 16.5: peripheral to memory, 16 bits, circular over whole scans. SAFETY: source and
        // ring are the addresses of the data register and of a buffer that lives for ever and is as long as
        // the count.
        unsafe {
            stream.par.write(|w| w.bits(source));
            stream.m0ar.write(|w| w.bits(ring));
            stream.ndtr.write(|w| w.bits((AVERAGED * inputs) as u32));
            stream.cr.write(|w| w.msize().bits16().psize().bits16().minc().set_bit().circ().set_bit());
        }
        stream.cr.modify(|_, w| w.en().set_bit());
    }

    /// Returns the average of the last 32 readings of the input at `position` in the list given to
    /// [`Self::start`], 0 to 65 535 for full scale.
    ///
    /// # Errors
    /// [`AdcError::NotFilled`] in the first moments, [`AdcError::ScanStopped`] when the DMA has stopped with
    /// an error, [`AdcError::BadInputs`] beyond the list.
    pub fn average(&self, position: usize) -> Result<u16, AdcError> {
        if position >= self.inputs {
            return Err(AdcError::BadInputs);
        }
        if !self.is_running() {
            return Err(AdcError::ScanStopped);
        }
        // RM0399 section 16.5.1: the flag comes with the end of the first round and is never cleared here.
        // Before that the ring holds zeros, which a thermistor would read as glowing.
        if self.dma.lisr.read().tcif1().bit_is_clear() {
            return Err(AdcError::NotFilled);
        }
        let sum = (0..AVERAGED)
            .filter_map(|scan| RING.read(scan * self.inputs + position))
            .fold(0_u32, |sum, sample| sum + u32::from(sample));
        Ok((sum / AVERAGED as u32) as u16)
    }

    /// Returns the newest reading of the input at `position`, 0 to 65 535 for full scale.
    ///
    /// # Errors
    /// As [`Self::average`]; readings exist from the first scan on.
    pub fn latest(&self, position: usize) -> Result<u16, AdcError> {
        if position >= self.inputs {
            return Err(AdcError::BadInputs);
        }
        if !self.is_running() {
            return Err(AdcError::ScanStopped);
        }
        // RM0399 sections 16.5.1 and 16.5.6: the flag comes with the end of the first round, the count falls
        // with each sample that was fetched.
        let is_filled = self.dma.lisr.read().tcif1().bit_is_set();
        let total = AVERAGED * self.inputs;
        let fetched = total.saturating_sub(self.samples_to_wrap() as usize);
        newest(position, self.inputs, fetched, is_filled).and_then(|place| RING.read(place)).ok_or(AdcError::NotFilled)
    }

    /// Returns the number of samples that the DMA has yet to write before it wraps; changes with every
    /// conversion while the scan is alive.
    #[must_use]
    pub fn samples_to_wrap(&self) -> u32 {
        self.dma.st[STREAM].ndtr.read().bits()
    }

    /// Returns whether the DMA is still enabled: it switches itself off on a transfer error.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.inputs > 0 && self.dma.st[STREAM].cr.read().en().bit_is_set()
    }
}

/// Returns the place in the ring of the newest sample of an input, when the DMA has fetched so many in this
/// round. The last one fetched may still be on its way to memory: it does not count.
const fn newest(position: usize, inputs: usize, fetched: usize, is_filled: bool) -> Option<usize> {
    let total = AVERAGED * inputs;
    let written = if is_filled { total + fetched } else { fetched };
    if written < position + 2 {
        return None;
    }
    Some(((written - 2 - position) / inputs * inputs + position) % total)
}

// Three inputs: nothing yet, the first sample on its way, in memory; then the newest one before a scan ends,
// and over the end of the ring.
const _: () = {
    assert!(newest(0, 3, 0, false).is_none() && newest(0, 3, 1, false).is_none());
    assert!(matches!(newest(0, 3, 2, false), Some(0)) && newest(1, 3, 2, false).is_none());
    assert!(matches!(newest(0, 3, 4, false), Some(0)) && matches!(newest(0, 3, 5, false), Some(3)));
    assert!(matches!(newest(2, 3, 0, true), Some(92)) && matches!(newest(2, 3, 1, true), Some(95)));
};

/// Longest time of a conversion; it takes 154 us.
const CONVERSION_LIMIT: units::Micros = units::Micros::from_millis(2);

/// Single readings of ADC3's inputs, taken round-robin without waiting: each [`Self::poll`] collects one and
/// starts the next.
pub struct Supplies {
    adc: pac::ADC3,
    calibration_begun: Result<(), AdcError>,
    ready: bool,
    /// The table's index of the input being converted.
    current: usize,
    /// Index of the input converted last in turn.
    turn: usize,
    readings: [Option<u16>; crate::pins::table::SUPPLIES.len()],
    /// Bit mask of the inputs to read.
    wanted: u16,
    /// Time at which the last conversion was begun.
    begun: units::Micros,
}

impl Supplies {
    pub(crate) fn new(adc: pac::ADC3, common: &pac::ADC3_COMMON) -> Self {
        // SAFETY: as for ADC1.
        common.ccr.modify(|_, w| unsafe { w.ckmode().bits(0).presc().bits(0b0011) });
        // Enables the chip's temperature sensor and reference. The battery's divider would drain the cell: it
        // is on only during its reading.
        common.ccr.modify(|_, w| w.vsenseen().set_bit().vrefen().set_bit());
        let calibration_begun = begin_calibration(&adc);
        let readings = [None; crate::pins::table::SUPPLIES.len()];
        Self { adc, calibration_begun, ready: false, current: 0, turn: 0, readings, wanted: 0, begun: units::Micros(0) }
    }

    /// Brings the converter up to read the inputs of these indices of [`crate::pins::table::SUPPLIES`]. Once.
    ///
    /// # Errors
    /// [`AdcError`].
    pub fn start(&mut self, inputs: &[usize]) -> Result<(), AdcError> {
        if inputs.is_empty() || inputs.iter().any(|index| *index >= self.readings.len()) {
            return Err(AdcError::BadInputs);
        }
        self.calibration_begun?;
        enable(&self.adc)?;
        self.wanted = inputs.iter().fold(0, |mask, index| mask | 1 << index);
        self.ready = true;
        self.convert_next();
        Ok(())
    }

    /// Collects a finished reading and starts the next. A converter that does not finish leaves its reading
    /// as `None`.
    pub fn poll(&mut self) {
        if self.collect() {
            self.convert_next();
        }
    }

    /// Returns the latest reading of this input and requests a new one, so that frequent calls get fresh
    /// values.
    pub fn follow(&mut self, input: usize) -> Option<u16> {
        if self.wanted & 1 << input != 0 && self.collect() {
            self.convert(input);
        }
        self.reading(input)
    }

    /// Returns the newest reading of this input as [`Self::follow`] does, but keeps the reading before while
    /// a conversion is under way: for callers that come as often as they like. `None` as well when the
    /// converter has stopped.
    pub fn latest(&mut self, input: usize) -> Option<u16> {
        let before = self.reading(self.current);
        if self.collect() {
            if self.wanted & 1 << input != 0 {
                self.convert(input);
            }
        } else if crate::time::now().since(self.begun) < CONVERSION_LIMIT {
            if let Some(slot) = self.readings.get_mut(self.current) {
                *slot = before;
            }
        } else {
            return None;
        }
        self.reading(input)
    }

    /// Stores the reading and returns whether the converter has finished.
    fn collect(&mut self) -> bool {
        if !self.ready {
            return false;
        }
        // Reading the data register clears the flag (RM0399 section 26.7.1).
        let reading = self.adc.isr.read().eoc().bit_is_set().then(|| self.adc.dr.read().bits() as u16);
        if self.current == VBAT && reading.is_some() {
            self.connect_battery(false);
        }
        if let Some(slot) = self.readings.get_mut(self.current) {
            *slot = reading;
        }
        reading.is_some()
    }

    /// The latest reading of an input, 0 to 65 535 for full scale.
    #[must_use]
    pub fn reading(&self, input: usize) -> Option<u16> {
        self.readings.get(input).copied().flatten()
    }

    fn convert_next(&mut self) {
        let count = self.readings.len();
        let next = (1..=count).map(|step| (self.turn + step) % count).find(|index| self.wanted & (1 << index) != 0);
        if let Some(index) = next {
            self.turn = index;
            self.convert(index);
        }
    }

    fn convert(&mut self, index: usize) {
        let Some(input) = crate::pins::table::SUPPLIES.get(index) else { return };
        self.current = index;
        if index == VBAT {
            self.connect_battery(true);
            if !self.ready {
                return;
            }
        }
        let channel = u32::from(input.channel);
        // SAFETY: the channel is from the board's table; a sequence of one.
        unsafe {
            self.adc.pcsel.write(|w| w.bits(1 << channel));
            self.adc.sqr1.write(|w| w.bits(channel << 6));
        }
        self.adc.cr.modify(|_, w| w.adstart().set_bit());
        self.begun = crate::time::now();
    }

    /// Connects the battery's divider to ADC3, or disconnects it (RM0399 section 26.8.2, VBATEN). Sampling
    /// for 152 us (810.5 cycles) gives it more than the time it needs (DS12923, "VBAT monitoring
    /// characteristics", tS_vbat: 9 us). The common register is to be written only while the converter is
    /// disabled (RM0399 section 26.4.10, "Constraints when writing the ADC control bits"); waiting for that
    /// takes a few microseconds. A converter that cannot be enabled again gives no more readings.
    fn connect_battery(&mut self, on: bool) {
        self.adc.cr.modify(|_, w| w.addis().set_bit());
        let is_off = wait::until(READY_LIMIT_US, || self.adc.cr.read().aden().bit_is_clear());
        if is_off.is_ok() {
            // SAFETY: this register is ADC3's alone; it is changed by the owner of `Supplies`, one at a time.
            unsafe { (*pac::ADC3_COMMON::ptr()).ccr.modify(|_, w| w.vbaten().bit(on)) };
        }
        self.ready = is_off.is_ok() && enable(&self.adc).is_ok();
    }
}

/// Volts at the pin for a 16-bit reading. VREF+ is tied to the 3.3 V supply.
#[must_use]
pub fn pin_volts(reading: u16) -> f32 {
    f32::from(reading) * (3.3 / 65_535.0)
}

/// Degrees Celsius for a reading of the chip's temperature sensor, by the two points it was calibrated at
/// (DS12923, "Temperature sensor calibration values": 30 and 110 degrees at 3.3 V). `None` for a chip without
/// calibration.
#[must_use]
pub fn chip_celsius(reading: u16) -> Option<f32> {
    const AT_30: *const u16 = 0x1FF1_E820 as *const u16;
    const AT_110: *const u16 = 0x1FF1_E840 as *const u16;
    // SAFETY: two half-words of read-only memory that every chip of the family has.
    let (cold, hot) = unsafe { (f32::from(AT_30.read_volatile()), f32::from(AT_110.read_volatile())) };
    (hot > cold).then(|| 30.0 + (f32::from(reading) - cold) * (80.0 / (hot - cold)))
}
