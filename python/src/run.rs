//! A job on a thread of its own while the interpreter is free: its words go to Python's callback, and Ctrl-C or an exception there end it.
//!
//! The job waits for the callback's answer, so that nothing is done after a callback has raised. It ends at the next place where it
//! looks at the clock or has something to tell, by unwinding, so that what it holds is given back; what takes long without such a place (a
//! search, a replay) is waited for so long as [`GRACE`] and then left to end by itself: it can write nothing and ask no server any more.
//!
//! A print is never left: once bytes go to a printer, Ctrl-C or an exception pauses it above the part, and the second Ctrl-C stops the printer.

use std::any::Any;
use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::time::{Duration, Instant};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::ThreadPoolBuilder;
use trunnion::job::{
    Bar, Clock, Installed, LoadedModel, OwnWeb, PlanResult, Progress, SliceResult, SystemClock, World,
};
use trunnion::publish::{self, Ask, ServerAnswer, Web};
use trunnion::slicing::Interrupt;

use crate::attended::{Attendant, Course, HEAD_START};
use crate::trouble::Trouble;

/// How often Python's signals are looked at.
const TICK: Duration = Duration::from_millis(50);
/// How long a cancelled job is waited for.
const GRACE: Duration = Duration::from_secs(2);
/// As much as a process's first thread has.
const STACK_BYTES: usize = 8 << 20;

thread_local! {
    /// What stops the slicers of the job on this thread: where they are looked for, only a function without surroundings can be given.
    static STOP: RefCell<Interrupt> = RefCell::new(Interrupt::default());
}

/// What a job unwinds with.
pub(crate) struct Cancelled;

fn unless_cancelled(stop: &Interrupt) {
    if stop.is_asked() {
        resume_unwind(Box::new(Cancelled));
    }
}

/// What a job tells: kind, text, done, of.
pub(crate) type Told = (&'static str, String, usize, usize);

enum Event<T> {
    /// The job waits until it is heard.
    Told(Told),
    /// A printer is at work, and nobody waits.
    Said(Told),
    Done(Result<Result<T, Trouble>, Box<dyn Any + Send>>),
}

/// The job's end of the talk.
struct Watch<T> {
    events: Sender<Event<T>>,
    heard: Receiver<()>,
    course: Arc<Course>,
}

impl<T> Watch<T> {
    fn tell(&self, told: Told) {
        unless_cancelled(&self.course.stop);
        // Nobody listens any more: cancelled.
        if self.events.send(Event::Told(told)).is_err() || self.heard.recv().is_err() {
            resume_unwind(Box::new(Cancelled));
        }
    }
}

impl<T> Progress for Watch<T> {
    fn warning(&self, text: &str) {
        self.tell(("warning", text.to_owned(), 0, 0));
    }

    fn begin(&self, what: &'static str, of: usize) -> Box<dyn Bar + '_> {
        self.tell(("step", what.to_owned(), 0, of));
        Box::new(Under { watch: self, what, of })
    }

    fn reached(&self, done: &dyn Any) {
        let name = match () {
            () if done.is::<LoadedModel>() => "read",
            () if done.is::<PlanResult>() => "planned",
            () if done.is::<SliceResult>() => "sliced",
            () => return,
        };
        self.tell(("reached", name.to_owned(), 0, 0));
    }
}

/// A step under way.
struct Under<'a, T> {
    watch: &'a Watch<T>,
    what: &'static str,
    of: usize,
}

impl<T> Bar for Under<'_, T> {
    fn at(&self, done: usize) {
        self.watch.tell(("step", self.what.to_owned(), done, self.of));
    }
}

/// The system's clock, at which a cancelled job ends.
struct Stoppable(Interrupt);

impl Clock for Stoppable {
    fn now(&self) -> Duration {
        unless_cancelled(&self.0);
        SystemClock.now()
    }

    fn sleep(&self, time: Duration) {
        SystemClock.sleep(time);
    }

    fn boot(&self) -> String {
        SystemClock.boot()
    }
}

/// This computer's way to servers, on which a cancelled job asks nothing more.
struct StoppableWeb(Interrupt);

impl Web for StoppableWeb {
    fn ask(&self, ask: &Ask<'_>, sent: &dyn Fn(usize)) -> Result<ServerAnswer, publish::Trouble> {
        unless_cancelled(&self.0);
        OwnWeb.ask(ask, sent)
    }

    fn wait(&self, time: Duration) {
        OwnWeb.wait(time);
    }

    fn speaks_tls(&self) -> bool {
        OwnWeb.speaks_tls()
    }
}

/// Does `work` on `threads` threads (0: as many as there are processors) and gives its result, or raises.
///
/// The threads are the call's own: a process that was forked has none of its parent's.
pub(crate) fn run<T: Send + 'static>(
    told: &Bound<'_, PyAny>,
    threads: usize,
    work: impl FnOnce(&World<'_>) -> Result<T, Trouble> + Send + 'static,
) -> PyResult<T> {
    run_attended(told, threads, false, move |world, _| work(world))
}

/// The same for `work` that may print, with Python standing by; `yes` agrees to what somebody must agree to.
pub(crate) fn run_attended<T: Send + 'static>(
    told: &Bound<'_, PyAny>,
    threads: usize,
    yes: bool,
    work: impl FnOnce(&World<'_>, &Attendant<'_>) -> Result<T, Trouble> + Send + 'static,
) -> PyResult<T> {
    let py = told.py();
    let course = Arc::new(Course::default());
    let (events, mut arriving) = mpsc::channel();
    let (hear, heard) = mpsc::channel();
    let watch = Watch { events: events.clone(), heard, course: Arc::clone(&course) };
    let pool = ThreadPoolBuilder::new().num_threads(threads).stack_size(STACK_BYTES).build();
    let pool = pool.map_err(|error| PyRuntimeError::new_err(format!("no threads could be started: {error}")))?;
    std::thread::spawn(move || {
        let done = catch_unwind(AssertUnwindSafe(|| pool.install(move || on_this_thread(&watch, yes, work))));
        // Nobody waits for what was cancelled.
        let _ = events.send(Event::Done(done));
    });
    // Why a print is to end.
    let mut raised: Option<PyErr> = None;
    loop {
        let (back, event) = py.detach(move || {
            let event = arriving.recv_timeout(TICK);
            (arriving, event)
        });
        arriving = back;
        let is_waited_for = matches!(event, Ok(Event::Told(_)));
        let answered = match event {
            Ok(Event::Done(done)) => return ended_by(py, raised, done),
            // Whoever has raised is told nothing more.
            Ok(Event::Told(words) | Event::Said(words)) if raised.is_none() => {
                told.call1(words).and_then(|_| py.check_signals())
            }
            Ok(Event::Told(_) | Event::Said(_)) | Err(RecvTimeoutError::Timeout) => py.check_signals(),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the job's thread ended without a result"));
            }
        };
        if let Err(error) = answered {
            if course.cancel() {
                drop(hear);
                py.detach(move || wait(&arriving));
                return Err(error);
            }
            if course.interrupt() {
                py.detach(|| std::thread::sleep(HEAD_START));
                course.stop_printer();
            }
            raised.get_or_insert(error);
        }
        if is_waited_for {
            // A job that has gone meanwhile says so itself.
            let _ = hear.send(());
        }
    }
}

fn on_this_thread<T>(
    watch: &Watch<T>,
    yes: bool,
    work: impl FnOnce(&World<'_>, &Attendant<'_>) -> Result<T, Trouble>,
) -> Result<T, Trouble> {
    let stop = &watch.course.stop;
    STOP.with(|own| *own.borrow_mut() = stop.clone());
    let slicers = Installed { interrupt: |_| STOP.with(|stop| stop.borrow().clone()) };
    let (clock, web) = (Stoppable(stop.clone()), StoppableWeb(stop.clone()));
    // Where nobody listens any more, the print ends by its interrupts.
    let say = |told| _ = watch.events.send(Event::Said(told));
    let attendant = Attendant::new(&watch.course, &say, yes);
    work(&World { slicers: &slicers, clock: &clock, web: &web, ..World::here(watch) }, &attendant)
}

/// Until the cancelled job has ended, but no longer than [`GRACE`].
fn wait<T>(arriving: &Receiver<Event<T>>) {
    let until = Instant::now() + GRACE;
    while let Some(left) = until.checked_duration_since(Instant::now()) {
        if let Ok(Event::Done(_)) | Err(_) = arriving.recv_timeout(left) {
            return;
        }
    }
}

/// What was raised while a print went on, with what became of that as its cause.
fn ended_by<T>(
    py: Python<'_>,
    raised: Option<PyErr>,
    done: Result<Result<T, Trouble>, Box<dyn Any + Send>>,
) -> PyResult<T> {
    let done = ended(py, done);
    let Some(raised) = raised else { return done };
    raised.set_cause(py, done.err());
    Err(raised)
}

fn ended<T>(py: Python<'_>, done: Result<Result<T, Trouble>, Box<dyn Any + Send>>) -> PyResult<T> {
    let panicked = |payload: Box<dyn Any + Send>| {
        let text = payload.downcast_ref::<String>().map(String::as_str).or(payload.downcast_ref::<&str>().copied());
        PyRuntimeError::new_err(format!("trunnion has a bug; report it: {}", text.unwrap_or("no words")))
    };
    done.map_err(panicked)?.map_err(|trouble| trouble.raised(py))
}
