//! Outcomes: what a check found, and what all checks of one program found.

/// Outcome of all checks of one program.
#[derive(Debug)]
pub struct Opinion {
    /// One entry a check, in the order they were made.
    pub checks: Vec<Check>,
}

/// Outcome of one check.
#[derive(Debug, Default)]
pub struct Check {
    /// Short name.
    pub name: &'static str,
    /// What was looked at or measured.
    pub figure: String,
    /// The first few failures.
    pub failures: Vec<String>,
    /// Number of all failures.
    pub count: usize,
    /// Why the check was not made.
    pub left_out: Option<String>,
}

impl Check {
    pub fn new(name: &'static str) -> Self {
        Self { name, ..Self::default() }
    }

    pub fn without(name: &'static str, why: &str) -> Self {
        Self { name, left_out: Some(why.to_owned()), ..Self::default() }
    }

    pub fn fail(&mut self, text: impl Into<String>) {
        self.count += 1;
        if self.failures.len() < 5 {
            self.failures.push(text.into());
        }
    }

    pub fn require<S: Into<String>>(&mut self, holds: bool, text: impl FnOnce() -> S) {
        if !holds {
            self.fail(text());
        }
    }

    /// Like `require`, of one line of the program.
    pub fn line<S: Into<String>>(&mut self, line: usize, holds: bool, text: impl FnOnce() -> S) {
        self.require(holds, || format!("line {line}: {}", text().into()));
    }
}
