//! Idle task: the machine's executor and its rest.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use base::Ports;
use base::ports::Wake;
use bsp_prime::thread_stack;
use machine::{Lasting, MACRO_CODE_BYTES, MACRO_LINES_BYTES, MacroMemory, MacroStore, MacroText, MacroVariables};

/// Whether there may be work for the executor.
static AWAKE: AtomicBool = AtomicBool::new(true);

/// Whether a session's inbox may have changed since the executor last asked.
static NEWS: AtomicBool = AtomicBool::new(true);

/// Number of rests of the executor, to measure delays.
static TURNS: AtomicU32 = AtomicU32::new(0);

/// Ends the executor's rest, or its next one. Called by the feed at each run and by whoever waits for the
/// executor; the step interrupt does not, or every step would cost a turn.
pub fn wake() {
    AWAKE.store(true, Ordering::Release);
}

/// Ends the rest as [`wake`] does, for a session: it has received something, or its peer came or went.
pub fn wake_for_session() {
    NEWS.store(true, Ordering::Release);
    wake();
}

/// Returns whether a session was woken for since the last call.
pub fn take_news() -> bool {
    NEWS.load(Ordering::Relaxed) && NEWS.swap(false, Ordering::AcqRel)
}

/// Runs the executor for ever, on the thread stack: its state is larger than DTCM.
pub fn run<P: Ports>(ports: impl FnOnce() -> P) -> ! {
    thread_stack::run(move || {
        let lasting = lasting();
        machine::run(ports(), lasting, macro_memory())
    })
}

#[unsafe(link_section = ".axisram")]
static mut LASTING: MaybeUninit<Lasting> = MaybeUninit::uninit();

/// Places the lasting data of the executor outside its stack. Call once. Never inlined: parts of the data are
/// on the stack meanwhile.
#[inline(never)]
fn lasting() -> &'static mut Lasting {
    let lasting = &raw mut LASTING;
    // SAFETY: `run` does not return and is called once, by `idle`, so this is the only reference there
    // ever is.
    unsafe { (*lasting).write(Lasting::new()) }
}

/// Code, values and stack of the macro that is rendered. All zero, as the section is.
#[unsafe(link_section = ".d2ram")]
static mut MACRO_CODE: [u8; MACRO_CODE_BYTES] = [0; MACRO_CODE_BYTES];
#[unsafe(link_section = ".d2ram")]
static mut MACRO_TEXT: MacroText = MacroText::new();
#[unsafe(link_section = ".d2ram")]
static mut MACRO_VARIABLES: MacroVariables = MacroVariables::new();
/// Lines of macros, and what is known of them: the core alone looks there. All zero, as the section is.
#[unsafe(link_section = ".itcm_data")]
static mut MACRO_LINES: [u8; MACRO_LINES_BYTES] = [0; MACRO_LINES_BYTES];
#[unsafe(link_section = ".itcm_data")]
static mut MACRO_STORE: MacroStore = MacroStore::new();

/// Returns the memory of macros. Call once.
fn macro_memory() -> MacroMemory<'static> {
    let (code, lines) = (&raw mut MACRO_CODE, &raw mut MACRO_LINES);
    let (text, variables, store) = (&raw mut MACRO_TEXT, &raw mut MACRO_VARIABLES, &raw mut MACRO_STORE);
    // SAFETY: `run` calls this once, so these are the only references there ever are. The board is up, so
    // both sections have been zeroed, which is what their statics are at first.
    unsafe {
        MacroMemory {
            code: &mut *code,
            lines: &mut *lines,
            text: &mut *text,
            variables: &mut *variables,
            store: &mut *store,
        }
    }
}

/// Lets the core sleep until the executor is woken.
pub fn rest(wake: Wake) {
    TURNS.store(TURNS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
    if wake == Wake::AtOnce {
        return;
    }
    while !AWAKE.swap(false, Ordering::Acquire) {
        // An interrupt that calls `wake` between the test and the sleep is seen at the feed's next run,
        // within a millisecond.
        rtic::export::wfi();
    }
}
