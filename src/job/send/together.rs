//! Several things at the same time, a thread each, for jobs that wait for the world and not for the processor.

use std::convert::Infallible;
use std::io::IsTerminal;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crossbeam_channel::bounded;

use super::desk::Desk;
use crate::link::serial::Address;

/// Does all `tasks`; a panic of one comes when the others have ended.
///
/// # Errors
///
/// The system's, where there is no thread for one of them: then none is begun.
pub(super) fn side_by_side<T: Send>(tasks: Vec<impl FnOnce() -> T + Send>) -> std::io::Result<Vec<T>> {
    let all_there = &AtomicBool::new(false);
    let ended: Vec<thread::Result<Option<T>>> = thread::scope(|scope| {
        // Nothing comes through it: it opens when its other end goes.
        let (gate, waits) = bounded::<Infallible>(0);
        let begin = |task: _| {
            let waits = waits.clone();
            let one = move || {
                let _ = waits.recv();
                all_there.load(Ordering::SeqCst).then(task)
            };
            thread::Builder::new().spawn_scoped(scope, one)
        };
        let threads = tasks.into_iter().map(begin).collect::<std::io::Result<Vec<_>>>();
        all_there.store(threads.is_ok(), Ordering::SeqCst);
        drop(gate);
        threads.map(|threads| threads.into_iter().map(|thread| thread.join()).collect())
    })?;
    Ok(ended.into_iter().filter_map(|ended| ended.unwrap_or_else(|panic| resume_unwind(panic))).collect())
}

/// The desk at which somebody types for `prints` that go on at the same time; `heard` is called behind each
/// line, with the reason where it means nothing. It closes where the
/// input ends, and never opens without a terminal.
pub fn desk(prints: usize, heard: impl Fn(Option<&str>) + Send + 'static) -> Arc<Desk> {
    let open = std::io::stdin().is_terminal();
    let desk = Arc::new(Desk::new(prints, open));
    let typed = Arc::clone(&desk);
    let read = move || {
        for line in std::io::stdin().lines().map_while(Result::ok) {
            heard(typed.typed(&line).err().as_deref());
        }
        typed.close();
    };
    if open && thread::Builder::new().spawn(read).is_err() {
        // Nobody would hear what is typed.
        desk.close();
    }
    desk
}

/// Whether two names lead to the same port: a device and a link to it are one.
pub(super) fn same_port(one: &Address, two: &Address) -> bool {
    match (one, two) {
        (Address::Device(one), Address::Device(two)) => {
            let real = |path: &std::path::Path| std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
            real(one) == real(two)
        }
        (one, two) => one == two,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_task_that_waits_for_another_does_not_hold_it_up() {
        let (send, wait) = crossbeam_channel::bounded(0);
        let tasks: Vec<Box<dyn FnOnce() -> u32 + Send>> =
            vec![Box::new(move || wait.recv().unwrap()), Box::new(move || send.send(7).map_or(0, |()| 8))];
        assert_eq!(side_by_side(tasks).unwrap(), [7, 8]);
    }

    #[test]
    fn a_link_to_a_device_is_that_device() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::write(at("tty"), "").unwrap();
        std::fs::write(at("other"), "").unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(at("tty"), at("by-id")).unwrap();
        let device = |name: &str| Address::Device(at(name));
        assert!(cfg!(not(unix)) || same_port(&device("tty"), &device("by-id")));
        assert!(!same_port(&device("tty"), &device("other")) && same_port(&device("gone"), &device("gone")));
        let tcp = |text: &str| Address::parse(text);
        assert!(same_port(&tcp("tcp:a:1"), &tcp("tcp:a:1")) && !same_port(&tcp("tcp:a:1"), &tcp("tcp:a:2")));
    }
}
