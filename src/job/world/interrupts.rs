//! Ctrl-C, TERM and a terminal that closes: what is done then is up to what is under way.
//!
//! A process has one handler, so that what it does stands in one place for all: until somebody says otherwise the program
//! ends there and then, but never while a file is being put in its place.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::link::serial::Twin;
use crate::slicing::Interrupt;

/// The exit code, as shells give it to what ends by Ctrl-C.
pub(crate) const EXIT_CODE: u8 = 130;

/// Slicers are stopped and their files cleared within this; then the program ends without.
const GRACE: Duration = Duration::from_secs(5);
const NAP: Duration = Duration::from_millis(5);

type Action = Arc<dyn Fn() + Send + Sync>;

/// What an interrupt does; `None` ends the program.
static ACTION: Mutex<Option<Action>> = Mutex::new(None);

/// How many files are being put in their places.
static HELD: AtomicUsize = AtomicUsize::new(0);

/// From now on an interrupt does `action` and nothing else.
pub(crate) fn on_interrupt(action: impl Fn() + Send + Sync + 'static) {
    *ACTION.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::new(action));
    // A second call changes nothing.
    let _ = ctrlc::set_handler(interrupted);
}

fn interrupted() {
    let action = ACTION.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match action {
        Some(action) => action(),
        None => end(),
    }
}

fn end() -> ! {
    wait_while(|| HELD.load(Ordering::SeqCst) > 0);
    // Nobody is left who could be told otherwise.
    let _ = writeln!(std::io::stderr(), "error: interrupted");
    std::process::exit(i32::from(EXIT_CODE))
}

fn wait_while(busy: impl Fn() -> bool) {
    let until = Instant::now() + GRACE;
    while Instant::now() < until && busy() {
        std::thread::sleep(NAP);
    }
}

/// From now on an interrupt stops the slicers that are given the result, clears `scratch`, and ends the program.
pub(crate) fn stop_slicers(scratch: &Path) -> Interrupt {
    let interrupt = Interrupt::default();
    let (asked, scratch) = (interrupt.clone(), scratch.to_owned());
    if outlives_its_terminal() {
        return interrupt;
    }
    on_interrupt(move || {
        let slicing = asked.is_running();
        asked.ask();
        if slicing {
            // The work's own thread says why, clears up and ends the program in better order.
            std::thread::sleep(GRACE);
        }
        let _ = std::fs::remove_dir_all(&scratch);
        end()
    });
    interrupt
}

/// Whether this was started with nohup: our handler would be called for what it was told to ignore.
fn outlives_its_terminal() -> bool {
    const HANG_UP: u64 = 1;
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| u64::from_str_radix(line.strip_prefix("SigIgn:")?.trim(), 16).ok());
    ignored.is_some_and(|mask| mask & HANG_UP != 0)
}

/// A file is being put in its place: an interrupt waits until this is dropped.
pub(crate) struct Held(());

pub(crate) fn held() -> Held {
    HELD.fetch_add(1, Ordering::SeqCst);
    if !outlives_its_terminal() {
        let _ = ctrlc::set_handler(interrupted);
    }
    Held(())
}

impl Drop for Held {
    fn drop(&mut self) {
        HELD.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Interrupts so far: once is a safe pause, twice an emergency stop.
static INTERRUPTS: AtomicU32 = AtomicU32::new(0);

/// What the second interrupt writes by itself, were the print's own thread held up by a disk or by a screen that takes nothing.
static LAST_WORDS: Mutex<Option<(Twin, &'static [u8])>> = Mutex::new(None);

/// More than the print's own thread naps, and soon enough.
const HEAD_START: Duration = Duration::from_millis(300);

/// From now on an interrupt is counted, and from the second on the last words are written.
pub(crate) fn count() {
    on_interrupt(|| {
        if INTERRUPTS.fetch_add(1, Ordering::Relaxed) == 0 {
            return;
        }
        // The print's own thread stops in better order, if it still can.
        std::thread::sleep(HEAD_START);
        if let Some((port, words)) = LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner).as_mut() {
            port.write(words);
        }
    });
}

/// How many there were.
pub(crate) fn counted() -> u32 {
    INTERRUPTS.load(Ordering::Relaxed)
}

/// None were.
pub(crate) fn forget() {
    INTERRUPTS.store(0, Ordering::Relaxed);
}

/// What is written from the second one on, and where.
pub(crate) fn last_words(words: Option<(Twin, &'static [u8])>) {
    *LAST_WORDS.lock().unwrap_or_else(PoisonError::into_inner) = words;
}
