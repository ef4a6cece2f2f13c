//! Counts the memory that the process has taken. At a limit the process ends with an error message instead of an abort.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

static USED_BYTES: AtomicUsize = AtomicUsize::new(0);
static PEAK_BYTES: AtomicUsize = AtomicUsize::new(0);
static LIMIT_BYTES: AtomicUsize = AtomicUsize::new(usize::MAX);
static CLEAN_UP: OnceLock<fn()> = OnceLock::new();
/// Whether the process is ending because memory ran out.
static ENDS: AtomicBool = AtomicBool::new(false);

/// Exit code of a process that ran out of memory. Its results could not be written.
const OUT_OF_MEMORY: i32 = 4;

/// The message of a process that runs out of memory. Writing it takes no memory.
const SAYS: &[u8] = b"luxmc: error: out of memory
  got:      a computation that needs more memory than there is, or than --memory-limit allows
  expected: enough for the scene, its maps and the files that are written
  remedy:   ask for fewer maps with --maps, use a larger max_element_edge, or raise --memory-limit; nothing was written
";

/// The system's allocator with a count and a limit. The program takes all its memory from it.
pub struct CountedMemory;

/// Sets the bytes that the process may take.
pub fn set_limit_bytes(bytes: u64) {
    LIMIT_BYTES.store(usize::try_from(bytes).unwrap_or(usize::MAX), Ordering::Relaxed);
}

/// Returns the bytes that the process may take; `u64::MAX` where there is no limit.
pub fn limit_bytes() -> u64 {
    match LIMIT_BYTES.load(Ordering::Relaxed) {
        usize::MAX => u64::MAX,
        bytes => bytes as u64,
    }
}

/// Returns the bytes that the process has taken and not given back; 0 where they are not counted.
pub fn used_bytes() -> u64 {
    USED_BYTES.load(Ordering::Relaxed) as u64
}

/// Returns the largest number of bytes that the process has held at one time; 0 where they are not counted.
pub fn peak_bytes() -> u64 {
    PEAK_BYTES.load(Ordering::Relaxed) as u64
}

/// Returns the bytes of a list whose capacity doubles whenever it is full. The result depends on the length alone, so that decisions based
/// on it do not depend on how the list was filled.
pub fn bytes_of_list<T>(list: &[T]) -> usize {
    size_of::<T>() * if list.is_empty() { 0 } else { list.len().next_power_of_two() }
}

/// Counts bytes before they are taken, and returns whether the limit allows them.
fn count(bytes: usize) -> bool {
    let used = USED_BYTES.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes);
    if used > PEAK_BYTES.load(Ordering::Relaxed) {
        PEAK_BYTES.fetch_max(used, Ordering::Relaxed);
    }
    used <= LIMIT_BYTES.load(Ordering::Relaxed)
}

fn give_back(bytes: usize) {
    USED_BYTES.fetch_sub(bytes, Ordering::Relaxed);
}

/// Sets the function that the process calls before it ends for lack of memory, to remove unfinished output. The limit no longer holds
/// during that call.
pub fn clean_up_by(clean: fn()) {
    CLEAN_UP.set(clean).ok();
}

thread_local! {
    static IS_ENDING: Cell<bool> = const { Cell::new(false) };
}

/// Ends the process with the message: the caller cannot continue without the memory.
#[cold]
fn end() -> ! {
    if IS_ENDING.replace(true) {
        // The cleanup itself ran out of memory.
        leave();
    }
    while ENDS.swap(true, Ordering::SeqCst) {
        // Another thread is already ending the process.
        std::thread::park();
    }
    let mut errors = std::io::stderr();
    errors.write_all(SAYS).and_then(|()| errors.flush()).ok();
    LIMIT_BYTES.store(usize::MAX, Ordering::Relaxed);
    if let Some(clean) = CLEAN_UP.get() {
        clean();
    }
    leave()
}

fn leave() -> ! {
    // Skips exit handlers, because they could take memory.
    #[cfg(unix)]
    signal_hook::low_level::exit(OUT_OF_MEMORY);
    #[cfg(not(unix))]
    std::process::exit(OUT_OF_MEMORY)
}

/// Returns the allocated pointer; ends the process if it is null.
fn counted(place: *mut u8) -> *mut u8 {
    if place.is_null() { end() } else { place }
}

// SAFETY: all memory comes from the system's allocator and goes back to it, with the caller's own layouts.
unsafe impl GlobalAlloc for CountedMemory {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if !count(layout.size()) {
            end();
        }
        // SAFETY: the layout is the caller's.
        counted(unsafe { System.alloc(layout) })
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if !count(layout.size()) {
            end();
        }
        // SAFETY: the layout is the caller's.
        counted(unsafe { System.alloc_zeroed(layout) })
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        give_back(layout.size());
        // SAFETY: the system's allocator returned `place` for this layout.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        if new_size > layout.size() {
            if !count(new_size - layout.size()) {
                end();
            }
        } else {
            give_back(layout.size() - new_size);
        }
        // SAFETY: the system's allocator returned `place` for this layout.
        counted(unsafe { System.realloc(place, layout, new_size) })
    }
}
