//! A board with the boot stage of the image under test, and applications of a few instructions behind it,
//! each of which leaves a number in memory that tells which one the boot stage has started.

use crate::common::switched::put;
use board_facts::wiring::{DRIVERS, MOTORS_ENABLE, OUTPUT_BUFFER_ENABLE, SUPPLY_SWITCH};
use rigless::soc::Width;
use sim::models::sd_card::SdCard;
use sim::world::WorldConfig;
use update::{
    Entry, Failed, Flash, Known, Log, MANIFEST_BYTES, Manifest, PRIME, Sector, Unreadable, VECTOR_TABLE, Word,
};
use virtual_prime::board::{PinChange, PrimeBoard};
use virtual_prime::console::Line;
use virtual_prime::flash_journal::{FlashContent, Operation, SECTOR, WORD};
use virtual_prime::vm::{Span, Vm};

use crate::common::machine::pin;
use crate::common::{MS, velvet};

/// Address of the application's number: the last words of AXI SRAM, which the boot stage does not use.
const MARK: u32 = 0x2407_FFF0;
/// Upper half of the number's word.
const MARKED: u32 = 0x5EED_0000;
/// Stack of an application, the end of DTCM.
const STACK: u32 = 0x2002_0000;
/// Address of the code, behind the manifest: 16 vectors, then code.
const CODE: u32 = VECTOR_TABLE + 64;

/// Builds an application of so many bytes, as the linker leaves it, that leaves this number and sleeps until
/// the watchdog ends it.
pub fn linked(number: u8, bytes: usize) -> Vec<u8> {
    let mut image: Vec<u8> = (0..bytes).map(|at| (at as u8).wrapping_mul(37) ^ number).collect();
    image[..MANIFEST_BYTES].copy_from_slice(&Manifest::draft("small", &PRIME));
    let entry = PRIME.image_address() + CODE + 1;
    for (vector, value) in [STACK, entry].into_iter().chain([entry; 14]).enumerate() {
        let at = VECTOR_TABLE as usize + 4 * vector;
        image[at..at + 4].copy_from_slice(&value.to_le_bytes());
    }
    let mut code = Vec::new();
    // RCC_RSR: RMVF, so that the next reset shows its own cause (RM0399 section 9.7.39). STR R1, [R0].
    code.extend(put(0, 0x5802_44D0));
    code.extend(put(1, 1 << 16));
    code.push(0x6001);
    code.extend(put(0, MARK));
    code.extend(put(1, MARKED | u32::from(number)));
    // STR R1, [R0]; WFI; B to the WFI.
    code.extend([0x6001, 0xBF30, 0xE7FD]);
    for (place, halfword) in code.into_iter().enumerate() {
        let at = CODE as usize + 2 * place;
        image[at..at + 2].copy_from_slice(&halfword.to_le_bytes());
    }
    image
}

/// Builds a sealed application; with a signature where there is a key.
pub fn application(number: u8, bytes: usize, key: Option<&[u8; 32]>) -> Vec<u8> {
    let mut image = linked(number, bytes);
    update::seal(&mut image, &PRIME, key).expect("an image");
    image
}

/// Describes an image as the log does.
pub fn known(image: &[u8]) -> Known {
    let manifest = image.first_chunk().expect("a manifest");
    Known::of(&Manifest::parse(manifest, &PRIME).expect("a good one"))
}

/// Builds a flash with the boot stage, and this image behind it.
pub fn flash(image: &[u8]) -> FlashContent {
    let elf = std::fs::read(velvet::image()).expect("the image");
    let mut content = FlashContent::default();
    let file = object::File::parse(&*elf).expect("an ELF file");
    let boot = object::Object::section_by_name(&file, ".boot").expect("a sealed image");
    content.put(0, object::ObjectSection::data(&boot).expect("its bytes"));
    content.put(PRIME.image() as usize, image);
    content
}

/// View of the flash for the crate `update`, for events before a test.
pub struct Before<'f>(pub &'f mut FlashContent);

impl Flash for Before<'_> {
    fn read(&mut self, at: u32) -> Result<Word, Unreadable> {
        self.0.word(at as usize).ok_or(Unreadable)
    }

    fn program(&mut self, at: u32, word: &Word) -> Result<(), Failed> {
        self.0.apply(&Operation::Program(at as usize, *word));
        Ok(())
    }

    fn erase(&mut self, sector: Sector) -> Result<(), Failed> {
        self.0.apply(&Operation::Erase(sector.0 as usize));
        Ok(())
    }
}

/// Adds an entry to the log.
pub fn log(content: &mut FlashContent, entry: Entry) {
    let mut flash = Before(content);
    Log::read(&mut flash, &PRIME).append(&mut flash, entry).expect("room");
}

/// Builds a card with these files.
pub fn card(files: &[(&str, &[u8])]) -> Vec<u8> {
    let files: Vec<_> = files.iter().map(|(name, bytes)| ((*name).to_owned(), bytes.to_vec())).collect();
    virtual_prime::sd_image::build_fat16(&files).expect("a volume")
}

/// Whether a pin change is forbidden while the boot stage runs: the output buffer or the outputs' supply
/// switched on, the motors enabled, a step.
fn is_on(change: &PinChange) -> bool {
    let is = |name| change.pin == pin(name);
    match change.high {
        true => is(SUPPLY_SWITCH) || DRIVERS.iter().any(|driver| is(driver.step)),
        false => is(OUTPUT_BUFFER_ENABLE) || is(MOTORS_ENABLE),
    }
}

/// A board that is switched on.
pub struct Small {
    pub vm: Vm,
    pub console: Line,
    said: String,
}

/// Result of a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Came {
    /// The application with this number runs.
    Runs(u8),
    /// The boot stage waits for an image.
    Waits,
}

impl Small {
    /// Switches the power on.
    pub fn on(content: &FlashContent, card: Option<&[u8]>) -> Self {
        let board = PrimeBoard::new(WorldConfig::default()).expect("the board's tables are right");
        Self::on_board(board, content, card)
    }

    /// Switches the power on, with a 25 MHz crystal that does not start.
    pub fn without_crystal(content: &FlashContent) -> Self {
        let mut board = PrimeBoard::new(WorldConfig::default()).expect("the board's tables are right");
        board.set_crystal(false);
        Self::on_board(board, content, None)
    }

    fn on_board(mut board: PrimeBoard, content: &FlashContent, card: Option<&[u8]>) -> Self {
        board.insert(card.map(|card| SdCard::new(card.to_vec())));
        let guards = [OUTPUT_BUFFER_ENABLE, SUPPLY_SWITCH, MOTORS_ENABLE];
        let watched = guards.into_iter().chain(DRIVERS.map(|driver| driver.step));
        watched.for_each(|name| board.mcu.watch_pin(pin(name)));
        board.flash.keep();
        let console = board.console(0).clone();
        static NEXT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        let number = NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let elf = std::env::temp_dir().join(format!("velvet-flash-{}-{number}.elf", std::process::id()));
        std::fs::write(&elf, content.elf()).expect("a temporary file");
        let mut vm = Vm::start(board, &elf, None).expect("the image loads");
        // The file has been read.
        let _ = std::fs::remove_file(&elf);
        let spoiled = content.clone();
        vm.with(move |stopped| spoiled.spoil(stopped.host)).expect("the run goes on");
        Self { vm, console, said: String::new() }
    }

    /// Returns all words from the debug console.
    pub fn said(&mut self) -> &str {
        let heard = self.console.receive();
        self.said.push_str(&String::from_utf8_lossy(&heard));
        &self.said
    }

    /// Returns the application's number in memory.
    pub fn mark(&mut self) -> Option<u8> {
        let read = |stopped: &mut virtual_prime::vm::Stopped<'_>| stopped.host.read(u64::from(MARK), Width::W32);
        let mark = self.vm.with(read).expect("the run goes on").expect("AXI SRAM") as u32;
        (mark & 0xFFFF_0000 == MARKED).then_some(mark as u8)
    }

    /// Runs the board until an application runs, or the boot stage says that none may.
    pub fn settle(&mut self, patience_ms: u64) -> Came {
        let end = self.vm.now_ns() + patience_ms * MS;
        loop {
            assert_eq!(self.vm.run_for(5 * MS), Span::Reached);
            if let Some(number) = self.mark() {
                self.nothing_was_on();
                return Came::Runs(number);
            }
            if self.said().contains("no firmware that may run") {
                self.nothing_was_on();
                return Came::Waits;
            }
            assert!(self.vm.now_ns() < end, "nothing runs after {patience_ms} ms; it said: {}", self.said());
        }
    }

    /// Asserts that since power-on no heater, fan or motor has been on.
    #[track_caller]
    pub fn nothing_was_on(&mut self) {
        let take = |stopped: &mut virtual_prime::vm::Stopped<'_>| stopped.session.board_mut().mcu.take_pin_changes();
        let changes = self.vm.with(take).expect("the run goes on");
        assert_eq!(changes.iter().find(|change| is_on(change)), None);
    }

    /// Clears the number, to look for it anew.
    pub fn forget_mark(&mut self) {
        let write = |stopped: &mut virtual_prime::vm::Stopped<'_>| stopped.host.write(u64::from(MARK), Width::W32, 0);
        self.vm.with(write).expect("the run goes on").expect("AXI SRAM");
        self.said();
        self.said.clear();
    }

    /// Presses the RESET button.
    pub fn press_reset(&mut self) {
        let reset = |stopped: &mut virtual_prime::vm::Stopped<'_>| {
            stopped.session.reset_by_pin(stopped.stop.at, stopped.stop.instruction_count, stopped.host);
        };
        self.vm.with(reset).expect("the run goes on");
        self.said();
        self.said.clear();
    }

    /// Returns the operations on the flash since power-on.
    pub fn operations(&mut self) -> Vec<Operation> {
        self.vm.with(|stopped| stopped.session.board().flash.operations().to_vec()).expect("the run goes on")
    }
}

/// Returns the state that the log has.
pub fn state(content: &mut FlashContent) -> update::State {
    Log::read(&mut Before(content), &PRIME).state
}

/// Returns the flash after these operations.
pub fn after(content: &FlashContent, operations: &[Operation]) -> FlashContent {
    let mut content = content.clone();
    operations.iter().for_each(|operation| content.apply(operation));
    content
}

const _: () = assert!(WORD == update::WORD && SECTOR == PRIME.sector_bytes as usize);
