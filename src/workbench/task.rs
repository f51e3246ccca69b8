//! Jobs of the page: each is one command line, and all but one of them are for a printer. Pure values.

use super::printers::MOST_PRINTERS;

/// A job of the page. Each is one command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Task {
    /// All ways, the chosen one made into verified G-code, and its preview.
    Prepare,
    /// The print on the simulated printer.
    Rehearse,
    /// The print.
    Print,
    /// The print again, from its journal.
    Resume,
    /// The file to a print server.
    Publish,
    /// The same, and the print there.
    PublishAndStart,
}

impl Task {
    /// All of them.
    pub(super) const ALL: [Self; 6] =
        [Self::Prepare, Self::Rehearse, Self::Print, Self::Resume, Self::Publish, Self::PublishAndStart];

    /// Its name in addresses and documents.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Prepare => "prepare",
            Self::Rehearse => "rehearse",
            Self::Print => "print",
            Self::Resume => "resume",
            Self::Publish => "publish",
            Self::PublishAndStart => "publish-and-start",
        }
    }

    /// The task of that name.
    pub(super) fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|task| task.name() == name)
    }

    /// Whether it drives a real printer for as long as it runs.
    pub(super) fn prints(self) -> bool {
        matches!(self, Self::Print | Self::Resume)
    }

    /// Whether its result is one document, printed at its end; the others tell of events.
    pub(super) fn has_document(self) -> bool {
        self == Self::Prepare || self.publishes()
    }

    /// Whether it speaks to a print server, which wants a key.
    pub(super) fn publishes(self) -> bool {
        matches!(self, Self::Publish | Self::PublishAndStart)
    }
}

/// A job, and the number of the printer that it is for. Preparing is for all of them, and has that of the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct PrinterTask {
    /// The job.
    pub(super) task: Task,
    /// The printer.
    pub(super) printer: u8,
}

impl From<Task> for PrinterTask {
    /// For the first printer.
    fn from(task: Task) -> Self {
        Self { task, printer: 1 }
    }
}

impl PrinterTask {
    /// Its name in addresses and documents: `print` of the first printer, `print:2` of the second.
    pub(super) fn name(self) -> String {
        let name = self.task.name();
        if self.printer == 1 { name.to_owned() } else { format!("{name}:{}", self.printer) }
    }

    /// The one of that name.
    pub(super) fn of(name: &str) -> Option<Self> {
        let (name, printer) = numbered(name)?;
        let task = Task::of(name)?;
        (printer == 1 || task != Task::Prepare).then_some(Self { task, printer })
    }

    /// Whether one has to end before the other begins: two of one printer, and preparing, which writes the file that the others read.
    pub(super) fn excludes(self, other: Self) -> bool {
        self.printer == other.printer || [self, other].iter().any(|one| one.task == Task::Prepare)
    }
}

/// A name, and the number of the printer behind it; the first needs none, and has no other name.
pub(super) fn numbered(name: &str) -> Option<(&str, u8)> {
    let Some((name, number)) = name.split_once(':') else { return Some((name, 1)) };
    let number = number.parse().ok().filter(|number| (2..=MOST_PRINTERS).contains(number))?;
    Some((name, number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_has_one_name() {
        for task in Task::ALL {
            for printer in [1, 2, MOST_PRINTERS] {
                let one = PrinterTask { task, printer };
                let known = printer == 1 || task != Task::Prepare;
                assert_eq!(PrinterTask::of(&one.name()), known.then_some(one), "{}", one.name());
            }
        }
        let too_many = format!("print:{}", MOST_PRINTERS + 1);
        for name in
            ["print:1", "print:0", "print:", "print:x", "print:-2", "print:2:3", "prepare:2", "", ":2", &too_many]
        {
            assert_eq!(PrinterTask::of(name), None, "{name}");
        }
    }

    #[test]
    fn a_printer_does_one_thing_at_a_time_and_nothing_while_the_file_is_made() {
        let of = |task, printer| PrinterTask { task, printer };
        assert!(of(Task::Print, 1).excludes(of(Task::Publish, 1)) && !of(Task::Print, 1).excludes(of(Task::Print, 2)));
        assert!(of(Task::Prepare, 1).excludes(of(Task::Print, 2)) && of(Task::Print, 2).excludes(Task::Prepare.into()));
    }
}
