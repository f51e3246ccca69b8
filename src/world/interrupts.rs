//! Ctrl-C, TERM and a terminal that closes: what is done then is up to what is under way.
//!
//! A process has one handler of its signals, so that [`HANDLER`] and [`HELD`], which it asks, are the process's too; everything else
//! belongs to a print as a value, [`Interrupts`]. While prints are under way each of them is told. Else what was said last is done,
//! and until somebody says something the program ends there and then, but never while a file is being put in its place.

use std::io::Write;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use crate::link::serial::Twin;
use crate::slicing::Interrupt;

/// The exit code, as shells give it to what ends by Ctrl-C.
pub(crate) const EXIT_CODE: u8 = 130;

/// Slicers are stopped and their files cleared within this; then the program ends without.
const GRACE: Duration = Duration::from_secs(5);
const NAP: Duration = Duration::from_millis(5);

type OnInterrupt = Arc<dyn Fn() + Send + Sync>;

/// Whom the process's one signal handler asks.
struct Handler {
    /// What an interrupt does where nothing is printed; `None` ends the program.
    action: Option<OnInterrupt>,
    /// The prints under way.
    prints: Vec<Weak<Counter>>,
}

/// A signal comes to the process, not to a print: somebody must know whom to tell.
static HANDLER: Mutex<Handler> = Mutex::new(Handler { action: None, prints: Vec::new() });

/// How many files are being put in their places: the end of the process cuts off each of them, whoever writes it.
static HELD: AtomicUsize = AtomicUsize::new(0);

fn handler() -> MutexGuard<'static, Handler> {
    HANDLER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on an interrupt does `action`, unless something is printed.
pub(crate) fn on_interrupt(action: impl Fn() + Send + Sync + 'static) {
    handler().action = Some(Arc::new(action));
    // A second call changes nothing.
    let _ = ctrlc::set_handler(interrupted);
}

fn interrupted() {
    let (action, prints) = {
        let mut handler = handler();
        handler.prints.retain(|print| print.strong_count() > 0);
        (handler.action.clone(), handler.prints.iter().filter_map(Weak::upgrade).collect::<Vec<_>>())
    };
    match action {
        _ if !prints.is_empty() => tell(&prints),
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

/// Something is known and better is looked for: until this is dropped an interrupt says that it is enough, and the next one ends the program.
struct Enough {
    asked: Arc<AtomicBool>,
    /// What an interrupt did before.
    before: Option<OnInterrupt>,
}

impl Enough {
    /// From now on.
    fn listen() -> Self {
        let asked = Arc::new(AtomicBool::new(false));
        let before = handler().action.clone();
        let (first, then) = (asked.clone(), before.clone());
        if !outlives_its_terminal() {
            on_interrupt(move || match (first.swap(true, Ordering::Relaxed), &then) {
                (false, _) => {}
                (true, Some(then)) => then(),
                (true, None) => end(),
            });
        }
        Self { asked, before }
    }
}

impl Drop for Enough {
    fn drop(&mut self) {
        handler().action = self.before.take();
    }
}

/// Searches that may be ended early.
#[derive(Default)]
pub(crate) struct Searches(Mutex<Option<Enough>>);

impl Searches {
    /// One begins, or is over.
    pub(crate) fn begin(&self, begins: bool) {
        let mut search = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *search = None;
        *search = begins.then(Enough::listen);
    }

    /// Whether somebody wants it to end.
    pub(crate) fn enough(&self) -> bool {
        let search = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        search.as_ref().is_some_and(|search| search.asked.load(Ordering::Relaxed))
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

/// More than a print's own thread naps, and soon enough.
const HEAD_START: Duration = Duration::from_millis(300);

/// The interrupts of one print: once is a safe pause, twice an emergency stop. They come to it until it is dropped.
#[derive(Debug)]
pub(crate) struct Interrupts(Arc<Counter>);

#[derive(Debug, Default)]
struct Counter {
    count: AtomicU32,
    /// What the second interrupt writes by itself, were the print's own thread held up by a disk or by a screen that takes nothing.
    last_words: Mutex<Option<(Twin, &'static [u8])>>,
}

impl Counter {
    fn last_words(&self) -> MutexGuard<'_, Option<(Twin, &'static [u8])>> {
        self.last_words.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Interrupts {
    /// From now on every interrupt is counted here too, and ends nothing by itself.
    pub(crate) fn listen() -> Self {
        let counter = Arc::new(Counter::default());
        handler().prints.push(Arc::downgrade(&counter));
        let _ = ctrlc::set_handler(interrupted);
        Self(counter)
    }

    /// How many there were.
    pub(crate) fn count(&self) -> u32 {
        self.0.count.load(Ordering::Relaxed)
    }

    /// None were.
    pub(crate) fn forget(&self) {
        self.0.count.store(0, Ordering::Relaxed);
    }

    /// What is written from the second one on, and where.
    pub(crate) fn last_words(&self, words: Option<(Twin, &'static [u8])>) {
        *self.0.last_words() = words;
    }
}

/// Counts an interrupt for each of `prints`, and writes the last words of those that it stops.
fn tell(prints: &[Arc<Counter>]) {
    let counted = prints.iter().map(|print| (print, print.count.fetch_add(1, Ordering::Relaxed)));
    let stopped: Vec<_> = counted.filter(|(_, before)| *before > 0).map(|(print, _)| print).collect();
    if stopped.is_empty() {
        return;
    }
    // A print's own thread stops in better order, if it still can.
    std::thread::sleep(HEAD_START);
    for print in stopped {
        if let Some((port, words)) = print.last_words().as_mut() {
            port.write(words);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::serial::{Address, Port};
    use std::io::Read;
    use std::net::TcpListener;

    #[test]
    fn an_interrupt_is_told_to_every_print_and_forgotten_by_each_alone() {
        let [one, two] = [(), ()].map(|()| Interrupts::listen());
        let told = |prints: &[&Interrupts]| tell(&prints.iter().map(|p| Arc::clone(&p.0)).collect::<Vec<_>>());
        told(&[&one, &two]);
        assert_eq!((one.count(), two.count()), (1, 1));
        // The first goes on after its pause; for the second the next one is an emergency stop.
        one.forget();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let ports = [(), ()].map(|()| {
            let address = Address::Tcp(listener.local_addr().unwrap().to_string());
            let port = Port::open(&address, 115_200).unwrap();
            (port, listener.accept().unwrap().0)
        });
        let [(port_one, mut far_one), (port_two, mut far_two)] = ports;
        one.last_words(port_one.twin().map(|twin| (twin, &b"one"[..])));
        two.last_words(port_two.twin().map(|twin| (twin, &b"two"[..])));
        told(&[&one, &two]);
        assert_eq!((one.count(), two.count()), (1, 2));
        one.last_words(None);
        two.last_words(None);
        drop((port_one, port_two));
        let heard = |far: &mut std::net::TcpStream| {
            let mut text = String::new();
            far.read_to_string(&mut text).map(|_| text).unwrap()
        };
        assert_eq!((heard(&mut far_one), heard(&mut far_two)), (String::new(), "two".to_owned()));
    }

    #[test]
    fn a_print_that_has_ended_is_told_nothing() {
        let print = Interrupts::listen();
        let known =
            |counter: &Weak<Counter>| handler().prints.iter().any(|p| p.ptr_eq(counter) && p.strong_count() > 0);
        let counter = Arc::downgrade(&print.0);
        assert!(known(&counter));
        drop(print);
        assert!(!known(&counter));
    }
}
