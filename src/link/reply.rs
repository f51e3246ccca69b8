//! What a printer's line means.
//!
//! `ok` is only `^ok(\s|$)`: an `ok` glued into other text by noise is none. Texts: those of the firmwares
//! themselves, as `fixtures/wire/README.md` says.

use super::action::HostAction;

/// Whose answers they are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wording {
    /// Marlin's and `RepRapFirmware`'s.
    Printer,
    /// The same with Klipper's own `!!` and `//`.
    Klipper,
    /// Grbl's and its heirs'.
    Grbl,
}

/// Current and wanted temperatures, degrees Celsius.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Temperatures {
    /// The nozzle, and what it shall become.
    pub nozzle: Option<[f64; 2]>,
    /// The table, and what it shall become.
    pub bed: Option<[f64; 2]>,
}

/// Why a printer keeps the host waiting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Busy {
    /// It works.
    Processing,
    /// A person must do something: no time-out.
    User,
}

/// Grbl's `<Run|MPos:..|Bf:15,128>`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// `Idle`, `Run`, `Hold:0`, `Alarm`, ...
    pub state: String,
    /// Free planner blocks and free receive bytes.
    pub free: Option<[usize; 2]>,
    /// Machine position, in the firmware's order of axes.
    pub position: Vec<f64>,
    /// What is to be taken from it to have the file's coordinates, where the status says so.
    pub offset: Option<Vec<f64>>,
}

/// `P15 B3` of Marlin's ADVANCED_OK, true at the moment in which the `ok` was said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferRoom {
    /// Blocks that the planner still takes.
    pub planner: usize,
    /// Commands that the queue still takes; the one that is answered is still in it.
    pub commands: usize,
}

/// One line of a printer.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// `ok`, with what stands behind it.
    Ok {
        /// `N` of `ok N3 P15 B3`.
        number: Option<i64>,
        /// Whether it carries temperatures, as only the answer to M105 does.
        report: Option<Temperatures>,
        /// `P` and `B`.
        room: Option<BufferRoom>,
    },
    /// An `ok` that carries the answer to M115, as Klipper's does.
    OkIdentity(String),
    /// `Resend: 5`; `None` where the number cannot be read.
    Resend(Option<i64>),
    /// A wire error that the printer mends by a resend, with its `Last Line:`.
    LineError(Option<i64>),
    /// An error whose meaning is not known to be harmless.
    Error(String),
    /// The printer has stopped for good.
    Fatal(String),
    /// A sign of life.
    Busy(Busy),
    /// A report of its own accord.
    Temperatures(Temperatures),
    /// `X:10.00 Y:0.00 .. Count`: words and values.
    Position(Vec<(u8, f64)>),
    /// The firmware's first words after a reset.
    Greeting(String),
    /// `echo:Unknown command: ".."`, with the command.
    Unknown(String),
    /// `echo: cold extrusion prevented` and its like: the line in hand was not carried out as it is written, whatever `ok` follows.
    Undone(String),
    /// `echo:Unknown command: "hello trunnion 5f.1"`: the word of a line that it was not to know.
    Repeated(String),
    /// `FIRMWARE_NAME:..`, `[VER:..]`.
    Identity(String),
    /// Grbl's `error:22`.
    Refused(u32),
    /// Grbl's `ALARM:2`.
    Alarm(u32),
    /// Grbl's answer to `?`.
    Status(Status),
    /// What it asks of its host, in its words.
    Action(HostAction, String),
    /// Anything else: life, no meaning.
    Chatter,
}

impl Reply {
    /// Reads one line.
    pub fn read(wording: Wording, line: &[u8]) -> Self {
        if line == b"ok" {
            return Self::Ok { number: None, report: None, room: None };
        }
        let text = printable(line);
        if let Some(word) = repeated(&text) {
            return Self::Repeated(word.to_owned());
        }
        match wording {
            Wording::Grbl => grbl(&text),
            Wording::Printer => printer(&text),
            Wording::Klipper => klipper(&text).unwrap_or_else(|| printer(&text)),
        }
    }
}

impl Reply {
    /// Whether it answers a line, of whichever host.
    pub fn is_answer(&self) -> bool {
        matches!(
            self,
            Self::Ok { .. }
                | Self::OkIdentity(_)
                | Self::Resend(_)
                | Self::LineError(_)
                | Self::Unknown(_)
                | Self::Undone(_)
                | Self::Identity(_)
                | Self::Position(_)
                | Self::Refused(_)
                | Self::Status(_)
        )
    }
}

/// The word in `echo:Unknown command: "hello trunnion 5f.1"`, whatever the firmware's own words are; `None` for the bare line, which a terminal echoes
/// before anything is executed.
fn repeated(text: &str) -> Option<&str> {
    let (_, word) = text.split_once("hello trunnion ").filter(|(own, _)| !own.is_empty())?;
    Some(word.split(|c: char| !c.is_ascii_hexdigit() && c != '.').next().unwrap_or_default())
}

/// More than any firmware says in a line.
const LONGEST_TEXT: usize = 400;

/// A line as it may be shown: nothing in it moves a terminal's cursor or turns its letters round.
fn printable(line: &[u8]) -> String {
    let shown = |c: char| if c == ' ' || c.is_ascii_graphic() || c.is_alphanumeric() { c } else { '?' };
    String::from_utf8_lossy(line).chars().take(LONGEST_TEXT).map(shown).collect()
}

fn printer(text: &str) -> Reply {
    if let Some((action, words)) = HostAction::read(text) {
        return Reply::Action(action, words.to_owned());
    }
    if let Some(rest) = text.strip_prefix("ok")
        && rest.starts_with(|c: char| c.is_ascii_whitespace())
    {
        if rest.contains("FIRMWARE_NAME") {
            return Reply::OkIdentity(rest.trim().to_owned());
        }
        let number = word(rest, 'N');
        let count = |letter| word(rest, letter).and_then(|n| usize::try_from(n).ok());
        let room = count('P').zip(count('B')).map(|(planner, commands)| BufferRoom { planner, commands });
        return Reply::Ok { number, report: temperatures(rest), room };
    }
    if let Some(rest) = text.strip_prefix("Resend:").or_else(|| text.strip_prefix("rs ")) {
        return Reply::Resend(rest.trim().trim_start_matches('N').parse().ok());
    }
    // Sprinter's `Serial Error:`, Repetier's `fatal:`; Smoothie answers every line with `!!` once it has stopped.
    if let Some(body) = text.strip_prefix("Serial Error:").or_else(|| text.strip_prefix("Error:")) {
        return error(body.trim());
    }
    if let Some(body) = text.strip_prefix("fatal:") {
        return Reply::Fatal(body.trim().to_owned());
    }
    if text.starts_with("!!") {
        return Reply::Fatal(format!("it answers every line with {text:?} until M999 or a reset"));
    }
    echo(text)
}

/// The whole number behind `letter`, as a word of its own.
fn word(text: &str, letter: char) -> Option<i64> {
    text.split_ascii_whitespace().find_map(|w| w.strip_prefix(letter)?.parse().ok())
}

fn klipper(text: &str) -> Option<Reply> {
    if let Some(rest) = text.strip_prefix("!!") {
        return Some(Reply::Error(rest.trim().to_owned()));
    }
    let state = text.strip_prefix("// Klipper state: ")?.trim();
    let gone = matches!(state, "Shutdown" | "Disconnect");
    // Said only by one that has just begun.
    if state == "Ready" {
        return Some(Reply::Greeting(format!("Klipper state: {state}")));
    }
    Some(if gone { Reply::Fatal(format!("Klipper state: {state}")) } else { Reply::Chatter })
}

/// Pieces of the wire errors' texts: one wrong byte cannot spoil them all.
const WIRE_ERRORS: [&str; 6] = ["checksum", "mismatch", "Last Line", "Line Number", "with line", "Number+1"];
const FATAL: [&str; 9] = [
    "halted",
    "kill()",
    "KILL",
    "Thermal Runaway",
    "Heating failed",
    "MAXTEMP",
    "MINTEMP",
    "Printer stopped",
    "system stopped",
];

fn error(body: &str) -> Reply {
    if FATAL.iter().any(|f| body.contains(f)) {
        return Reply::Fatal(body.to_owned());
    }
    if let Some(wanted) = expected_line(body) {
        return Reply::LineError(Some(wanted - 1));
    }
    if WIRE_ERRORS.iter().any(|f| body.contains(f)) {
        let last = body.split_once("Last Line:").and_then(|(_, n)| n.trim().parse().ok());
        return Reply::LineError(last);
    }
    Reply::Error(body.to_owned())
}

/// The line that Repetier wants: `expected line 302 got 303`.
fn expected_line(body: &str) -> Option<i64> {
    let (wanted, _) = body.strip_prefix("expected line ")?.split_once(" got ")?;
    wanted.trim().parse().ok().filter(|n| (1..i64::MAX).contains(n))
}

fn echo(text: &str) -> Reply {
    if let Some(rest) = text.strip_prefix("echo:busy:") {
        let user = rest.contains("paused");
        return Reply::Busy(if user { Busy::User } else { Busy::Processing });
    }
    let said = text.strip_prefix("echo:").or_else(|| text.strip_prefix("// ")).unwrap_or(text).trim_start();
    let unknown = ["Unknown command:", "Unknown G code:", "Unknown M code:"].iter().find_map(|w| said.strip_prefix(w));
    if let Some(rest) = unknown {
        return Reply::Unknown(rest.trim().trim_matches('"').to_owned());
    }
    // RepRapFirmware 2: the line was not carried out, and its `ok` comes all the same.
    if said.to_ascii_lowercase().starts_with("checksum error on line") {
        return Reply::Error(said.to_owned());
    }
    if is_undone(said) {
        return Reply::Undone(said.to_owned());
    }
    if text == "start" || text == "PowerUp" || text.starts_with("Marlin ") || text.starts_with("RepRapFirmware for ") {
        return Reply::Greeting(text.to_owned());
    }
    if text.contains("FIRMWARE_NAME:") || text.starts_with("Cap:") {
        return Reply::Identity(text.to_owned());
    }
    if text.starts_with("X:") {
        return Reply::Position(position(text));
    }
    match temperatures(text) {
        Some(found) if text.starts_with([' ', 'T', 'B']) => Reply::Temperatures(found),
        _ => Reply::Chatter,
    }
}

/// Marlin's and Prusa's words for what they leave undone, `ok` or not; limits it cuts to without a word.
const UNDONE: [&str; 4] = ["cold extrusion prevented", "long extrusion prevented", "hotend too cold", "endstops hit"];

fn is_undone(said: &str) -> bool {
    let said = said.to_ascii_lowercase();
    UNDONE.iter().any(|words| said.contains(words)) || (said.starts_with("home ") && said.ends_with("first"))
}

/// The words of `X:10.00 Y:0.00 Z:0.00 A:9.00 C:0.00 E:7.00 Count X:-15200`, up to `Count`.
fn position(text: &str) -> Vec<(u8, f64)> {
    let stated = text.split(" Count").next().unwrap_or_default();
    let word = |w: &str| {
        let (letter, value) = w.split_once(':')?;
        Some((*letter.as_bytes().first()?, value.parse().ok()?))
    };
    stated.split_ascii_whitespace().filter_map(word).collect()
}

/// `T:19.38 /0.00 B:19.38 /0.00 @:0`, `T0:` for the first tool too, and the blank on either side of the slash or on none; `None`
/// without a temperature.
fn temperatures(text: &str) -> Option<Temperatures> {
    let mut found = Temperatures::default();
    let mut words = text.split_ascii_whitespace().peekable();
    while let Some(word) = words.next() {
        let Some((name, value)) = word.split_once(':') else { continue };
        let (now, behind) = value.split_once('/').map_or((value, None), |(now, behind)| (now, Some(behind)));
        let Ok(now) = now.parse::<f64>() else { continue };
        // What stands behind the slash, wherever that is: in this word, at its end, or before or in the next.
        let wanted = match (behind, words.peek().and_then(|next| next.strip_prefix('/'))) {
            (Some(""), _) => words.peek().copied(),
            (None, Some("")) => words.clone().nth(1),
            (behind, next) => behind.or(next),
        };
        let wanted = wanted.and_then(|w| w.parse().ok()).unwrap_or(0.0);
        match name {
            "T" | "T0" if found.nozzle.is_none() => found.nozzle = Some([now, wanted]),
            "B" => found.bed = Some([now, wanted]),
            _ => {}
        }
    }
    (found != Temperatures::default()).then_some(found)
}

fn grbl(text: &str) -> Reply {
    if let Some(code) = text.strip_prefix("error:") {
        return code.trim().parse().map_or(Reply::Error(text.to_owned()), Reply::Refused);
    }
    if let Some(code) = text.strip_prefix("ALARM:") {
        return Reply::Alarm(code.trim().parse().unwrap_or(0));
    }
    if text.starts_with("Grbl ") || text.starts_with("GrblHAL ") {
        return Reply::Greeting(text.to_owned());
    }
    if text.starts_with("[VER:") || text.starts_with("[OPT:") || text.starts_with("[AXS:") {
        return Reply::Identity(text.to_owned());
    }
    match text.strip_prefix('<').and_then(|t| t.strip_suffix('>')) {
        Some(inner) => Reply::Status(status(inner)),
        None => Reply::Chatter,
    }
}

fn numbers(list: &str) -> Vec<f64> {
    list.split(',').filter_map(|v| v.parse().ok()).collect()
}

fn status(inner: &str) -> Status {
    let mut fields = inner.split('|');
    let mut found = Status { state: fields.next().unwrap_or_default().to_owned(), ..Status::default() };
    for field in fields {
        let Some((name, value)) = field.split_once(':') else { continue };
        match name {
            "Bf" => {
                let both: Vec<usize> = value.split(',').filter_map(|v| v.parse().ok()).collect();
                found.free = <[usize; 2]>::try_from(both).ok();
            }
            "MPos" => found.position = numbers(value),
            "WCO" => found.offset = Some(numbers(value)),
            // The file's own coordinates, as some are set up to report.
            "WPos" => (found.position, found.offset) = (numbers(value), Some(Vec::new())),
            _ => {}
        }
    }
    found
}

#[cfg(test)]
mod tests;
