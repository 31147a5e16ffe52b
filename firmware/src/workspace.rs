//! Memory of the look-ahead at files: a second motion object, which makes no steps, and a second program.
//!
//! The memory is SRAM1 and SRAM2, slower than AXI SRAM, and nothing that moves waits for it.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};

use base::ports::Workspace;
use motion::{BlockRing, Motion, Store};

/// All zero, as the section is.
#[unsafe(link_section = ".d2ram")]
static mut BLOCKS: BlockRing = BlockRing::new();
#[unsafe(link_section = ".d2ram")]
static mut STORE: Store = Store::new();
#[unsafe(link_section = ".d2ram")]
static mut WORKSPACE: MaybeUninit<Workspace> = MaybeUninit::uninit();

static TAKEN: AtomicBool = AtomicBool::new(false);

/// Hands out the workspace, once. Never inlined: its parts are on the stack meanwhile.
#[inline(never)]
pub fn take() -> Option<&'static mut Workspace> {
    if TAKEN.swap(true, Ordering::Relaxed) {
        return None;
    }
    let (blocks, store, workspace) = (&raw mut BLOCKS, &raw mut STORE, &raw mut WORKSPACE);
    // SAFETY: this comes here once, so these are the only references there ever are. The board is up, so the
    // section has been zeroed, which is what its statics are at first.
    unsafe { Some((*workspace).write(Workspace::new(Motion::new(&mut *blocks, &mut *store)))) }
}

#[unsafe(link_section = ".d2ram")]
static mut OF_FILES: MaybeUninit<storage::Memory> = MaybeUninit::uninit();

/// Returns the memory of what goes on with the card's files. Called once, with the card's file system.
pub fn of_files() -> &'static mut storage::Memory {
    let memory = &raw mut OF_FILES;
    // SAFETY: the file system is made once, by `idle`, so this is the only reference there ever is; the
    // board is up, so the memory is there.
    unsafe { (*memory).write(storage::Memory::new()) }
}
