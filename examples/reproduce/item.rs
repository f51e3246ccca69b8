//! What a document prints, and what this run makes of it.

use serde_json::{Value, json};

/// A document with its tables and figures.
pub(crate) struct Document {
    /// The word of `--only`.
    pub(crate) key: &'static str,
    pub(crate) authors: &'static str,
    pub(crate) title: &'static str,
    pub(crate) year: u32,
    pub(crate) items: Vec<Item>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Table,
    Figure,
}

/// What became of a table or figure.
pub(crate) enum State {
    Remade,
    /// Remade on another object than the document's, since that is not given.
    StandIn(String),
    /// Not remade, and why.
    Left(String),
}

/// A table or figure.
pub(crate) struct Item {
    pub(crate) kind: Kind,
    /// As the document numbers it.
    pub(crate) number: &'static str,
    /// What it shows, in few words.
    pub(crate) caption: &'static str,
    pub(crate) state: State,
    pub(crate) rows: Vec<Row>,
    /// Each with a line below it, as SVG.
    pub(crate) pictures: Vec<(String, String)>,
    pub(crate) notes: Vec<String>,
}

/// A printed value beside ours.
pub(crate) struct Row {
    pub(crate) what: String,
    pub(crate) printed: String,
    pub(crate) ours: String,
    /// How far ours is from the printed, in `unit`; `None` where the two are not comparable.
    pub(crate) deviation: Option<f64>,
    /// The most that is expected.
    pub(crate) within: f64,
    pub(crate) unit: &'static str,
    /// Why they differ, or why they cannot be compared.
    pub(crate) reason: String,
}

impl Item {
    fn new(kind: Kind, number: &'static str, caption: &'static str, state: State) -> Self {
        Self { kind, number, caption, state, rows: Vec::new(), pictures: Vec::new(), notes: Vec::new() }
    }

    pub(crate) fn figure(number: &'static str, caption: &'static str) -> Self {
        Self::new(Kind::Figure, number, caption, State::Remade)
    }

    pub(crate) fn table(number: &'static str, caption: &'static str) -> Self {
        Self::new(Kind::Table, number, caption, State::Remade)
    }

    pub(crate) fn left(kind: Kind, number: &'static str, caption: &'static str, why: impl Into<String>) -> Self {
        Self::new(kind, number, caption, State::Left(why.into()))
    }

    pub(crate) fn stand_in(mut self, instead: impl Into<String>) -> Self {
        self.state = State::StandIn(instead.into());
        self
    }

    pub(crate) fn row(mut self, row: Row) -> Self {
        self.rows.push(row);
        self
    }

    pub(crate) fn rows(mut self, rows: impl IntoIterator<Item = Row>) -> Self {
        self.rows.extend(rows);
        self
    }

    pub(crate) fn picture(mut self, below: impl Into<String>, svg: String) -> Self {
        self.pictures.push((below.into(), svg));
        self
    }

    pub(crate) fn note(mut self, text: impl Into<String>) -> Self {
        self.notes.push(text.into());
        self
    }

    pub(crate) fn is_left(&self) -> bool {
        matches!(self.state, State::Left(_))
    }

    /// `Table 3.1.1`.
    pub(crate) fn name(&self) -> String {
        format!("{:?} {}", self.kind, self.number)
    }

    fn json(&self) -> Value {
        let (state, why) = match &self.state {
            State::Remade => ("remade", None),
            State::StandIn(instead) => ("stand-in", Some(instead)),
            State::Left(why) => ("left", Some(why)),
        };
        json!({
            "name": self.name(), "caption": self.caption, "state": state, "why": why,
            "rows": self.rows.iter().map(Row::json).collect::<Vec<_>>(),
            "pictures": self.pictures.len(), "notes": self.notes,
        })
    }
}

impl Row {
    /// Numbers that should agree to a share of the printed one.
    pub(crate) fn relative(what: impl Into<String>, printed: f64, ours: f64, within: f64) -> Self {
        let deviation = Some(100.0 * (ours - printed) / printed.abs());
        let (printed, ours) = (figures(printed), figures(ours));
        Self { what: what.into(), printed, ours, deviation, within: 100.0 * within, unit: "%", reason: String::new() }
    }

    /// Numbers that should agree to an amount.
    pub(crate) fn absolute(what: impl Into<String>, printed: f64, ours: f64, within: f64, unit: &'static str) -> Self {
        let deviation = Some(ours - printed);
        let (printed, ours) = (figures(printed), figures(ours));
        Self { what: what.into(), printed, ours, deviation, within, unit, reason: String::new() }
    }

    /// Words for a place beside words for another, so many degrees apart.
    pub(crate) fn apart(
        what: impl Into<String>,
        printed: impl Into<String>,
        ours: impl Into<String>,
        deg: f64,
        within: f64,
    ) -> Self {
        let (what, printed, ours) = (what.into(), printed.into(), ours.into());
        Self { what, printed, ours, deviation: Some(deg), within, unit: "deg", reason: String::new() }
    }

    /// Words that should be the same.
    pub(crate) fn same(what: impl Into<String>, printed: impl Into<String>, ours: impl Into<String>) -> Self {
        let (what, printed, ours) = (what.into(), printed.into(), ours.into());
        let deviation = Some(if printed == ours { 0.0 } else { 1.0 });
        Self { what, printed, ours, deviation, within: 0.0, unit: "words", reason: String::new() }
    }

    /// Values that cannot be compared, and why.
    pub(crate) fn open(
        what: impl Into<String>,
        printed: impl Into<String>,
        ours: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        let (what, printed, ours, reason) = (what.into(), printed.into(), ours.into(), reason.into());
        Self { what, printed, ours, deviation: None, within: 0.0, unit: "", reason }
    }

    /// Why they differ.
    pub(crate) fn because(mut self, reason: impl Into<String>) -> Self {
        self.reason = reason.into();
        self
    }

    /// Whether ours is as near as expected; `None` where the two are not comparable.
    pub(crate) fn holds(&self) -> Option<bool> {
        self.deviation.map(|off| off.abs() <= self.within)
    }

    fn json(&self) -> Value {
        json!({
            "what": self.what, "printed": self.printed, "ours": self.ours, "deviation": self.deviation,
            "within": self.within, "unit": self.unit, "holds": self.holds(), "reason": self.reason,
        })
    }
}

impl Document {
    /// How many of a kind there are, and how many of these are not left.
    pub(crate) fn count(&self, kind: Kind) -> [usize; 2] {
        let all = self.items.iter().filter(|item| item.kind == kind);
        [all.clone().count(), all.filter(|item| !item.is_left()).count()]
    }

    pub(crate) fn json(&self) -> Value {
        json!({
            "key": self.key, "authors": self.authors, "title": self.title, "year": self.year,
            "items": self.items.iter().map(Item::json).collect::<Vec<_>>(),
        })
    }
}

/// Six figures, without zeros behind them; small and large numbers with their power of ten.
pub(crate) fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{}", value + 0.0);
    }
    let power = value.abs().log10().floor();
    if !(-4.0..7.0).contains(&power) {
        return format!("{value:.4e}");
    }
    let decimals = (5.0 - power).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
