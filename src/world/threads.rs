//! The threads of all loops that run side by side: as many as asked for, and where the system gives fewer, those.

use std::thread::{Builder, available_parallelism};

use crossbeam_channel::unbounded;
use rayon::{ThreadBuilder, ThreadPoolBuilder};

/// What rayon asks too, which would panic in the midst of the work where one thread of them cannot be started.
const VARIABLE: &str = "RAYON_NUM_THREADS";
/// More are no help, and each takes memory.
const MOST: usize = 1024;

/// Starts them for the process; this thread works alone where it gets no other. A second call changes nothing.
pub(crate) fn start_threads() {
    let asked = std::env::var(VARIABLE).ok().and_then(|text| text.parse().ok()).filter(|count| *count > 0);
    let wanted: usize = asked.unwrap_or_else(|| available_parallelism().map_or(1, usize::from)).min(MOST);
    let (hand_out, waits) = unbounded::<ThreadBuilder>();
    let begin = |_: &usize| {
        let waits = waits.clone();
        Builder::new().spawn(move || waits.recv().map(ThreadBuilder::run)).is_ok()
    };
    let started = (0..wanted).take_while(begin).count();
    let threads = ThreadPoolBuilder::new();
    let done = match started {
        0 => threads.num_threads(1).use_current_thread().build_global(),
        _ => threads
            .num_threads(started)
            .spawn_handler(|thread| hand_out.send(thread).map_err(|_| std::io::ErrorKind::BrokenPipe.into()))
            .build_global(),
    };
    // There are some already: the ones that wait end with `hand_out`.
    drop(done);
}
