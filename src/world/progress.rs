//! Whoever watches a job: what is done, what should be known, how far a long step is.

use std::any::Any;

/// Told while a job goes on; every method may do nothing.
pub trait Progress {
    /// Something that should be known, in one sentence.
    fn warning(&self, text: &str);

    /// A step of `of` pieces begins; dropped at its end.
    fn begin(&self, what: &'static str, of: usize) -> Box<dyn Bar + '_>;

    /// A search begins that may be ended early, since there is `known` to fall back on; with `None` it is over.
    fn may_end(&self, _known: Option<&str>) {}

    /// Whether somebody wants such a search to end with the best so far.
    fn enough(&self) -> bool {
        false
    }

    /// A step is done, and this is what it came to: a [`LoadedModel`](crate::input::LoadedModel) that is read, the
    /// [`PlanResult`](crate::strategy::PlanResult) or the [`SliceResult`](crate::job::SliceResult) of [`prepare`](crate::job::prepare()).
    fn reached(&self, _done: &dyn Any) {}
}

/// A step that is under way.
pub trait Bar {
    /// `done` pieces are done.
    fn at(&self, done: usize);
}

/// Nobody watches; warnings are in the results as well.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn warning(&self, _: &str) {}

    fn begin(&self, _: &'static str, _: usize) -> Box<dyn Bar + '_> {
        Box::new(Self)
    }
}

impl Bar for Silent {
    fn at(&self, _: usize) {}
}

/// Whoever listens to crate [`log`]: warnings as `warn`, the beginning of a step as `info`, how far it is as `debug`; all with the target
/// `trunnion`. A host program's own logger decides what becomes of them, and without one nothing does.
#[derive(Clone, Copy, Debug, Default)]
pub struct Logging;

/// What the records of [`Logging`] are filed under.
const TARGET: &str = "trunnion";

impl Progress for Logging {
    fn warning(&self, text: &str) {
        log::warn!(target: TARGET, "{text}");
    }

    fn begin(&self, what: &'static str, of: usize) -> Box<dyn Bar + '_> {
        log::info!(target: TARGET, "{what}: {of} to do");
        Box::new(LoggingStep { what, of })
    }
}

struct LoggingStep {
    what: &'static str,
    of: usize,
}

impl Bar for LoggingStep {
    fn at(&self, done: usize) {
        log::debug!(target: TARGET, "{}: {done} of {}", self.what, self.of);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    static HEARD: Mutex<Vec<String>> = Mutex::new(Vec::new());

    /// A host program's logger.
    struct Host;

    impl log::Log for Host {
        fn enabled(&self, metadata: &log::Metadata<'_>) -> bool {
            metadata.target() == "trunnion"
        }

        fn log(&self, record: &log::Record<'_>) {
            if self.enabled(record.metadata()) {
                HEARD.lock().unwrap().push(format!("{} {}", record.level(), record.args()));
            }
        }

        fn flush(&self) {}
    }

    #[test]
    fn a_hosts_logger_hears_warnings_and_steps() {
        log::set_logger(&Host).unwrap();
        log::set_max_level(log::LevelFilter::Debug);
        Logging.warning("the model was mended");
        Logging.begin("slicing", 3).at(2);
        log::set_max_level(log::LevelFilter::Warn);
        Logging.begin("slicing", 3).at(3);
        assert_eq!(
            *HEARD.lock().unwrap(),
            ["WARN the model was mended", "INFO slicing: 3 to do", "DEBUG slicing: 2 of 3"]
        );
    }
}
