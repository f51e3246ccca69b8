//! Hosts and printers that die at any byte of what they say to each other, again and again, also while a host resumes, and ports in which answers
//! to an earlier host were left unread. In virtual time. Whatever happens every line is executed once, or the print stops with its reason behind
//! a beginning of the file.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use trunnion::link::sim::{Logged, Quirks, SURVIVABLE, Script, Sim};
use trunnion::link::{
    Header, JournalSummary, Notice, Outcome, Program, Protocol, Record, Sender, SenderSettings, StopReason,
};

use super::bench_machine::{blocks, joined, program, settings, text, without_padding};
use crate::support::{Numbers, note, seeds};

/// So often a journal is told what is proven.
const GROUP: Duration = Duration::from_millis(200);

/// No conversation takes as long.
const BOUND: Duration = Duration::from_secs(4 * 3600);

/// A printer, what its port holds, and the journal of the hosts that came and went.
struct Bench {
    numbers: Numbers,
    program: Arc<Program>,
    protocol: Protocol,
    sim: Sim,
    now: Duration,
    journal: String,
    acked: (i64, Duration),
    /// What the printer has said and no host has read.
    port: Vec<u8>,
    /// What it has said last, line by line.
    said: Vec<String>,
    /// Answers that come up when the next host has said something.
    late: Vec<u8>,
    hosts: u64,
    executed: Vec<String>,
    /// For the message of a failing test.
    told: Vec<String>,
}

/// How a host has ended.
#[derive(Debug)]
enum End {
    Killed,
    Over(Outcome),
}

/// What befalls a host, by the bytes that have gone either way since it began.
#[derive(Clone, Copy, Debug)]
struct Fate {
    killed: u64,
    reset: u64,
    unplugged: u64,
}

const NEVER: u64 = u64::MAX;

impl Bench {
    fn new(protocol: Protocol, seed: u64, quirks: Quirks, script: Script, moves: u32) -> Self {
        let program = program(protocol, &text(protocol, moves));
        let link = joined(&program, settings(protocol), quirks, script);
        Self {
            numbers: Numbers::seeded(seed ^ 0x5eed),
            program,
            protocol,
            sim: link.sim,
            now: link_time(protocol),
            journal: Header::default().to_text(),
            acked: (0, Duration::ZERO),
            port: Vec::new(),
            said: Vec::new(),
            late: Vec::new(),
            hosts: 0,
            executed: Vec::new(),
            told: Vec::new(),
        }
    }

    fn settings(&self) -> SenderSettings {
        SenderSettings { nonce: 7 * self.hosts + 1, ..settings(self.protocol) }
    }

    fn standing(&self) -> JournalSummary {
        JournalSummary::parse(&self.journal).unwrap_or_else(|e| panic!("{e}\n{}", self.journal))
    }

    /// The next host, as `job` has it: one that asks for the counter, or for the place; `None` where the journal leads nowhere.
    fn host(&mut self) -> Option<Sender> {
        self.hosts += 1;
        self.acked = (0, self.now);
        let (program, settings) = (Arc::clone(&self.program), self.settings());
        if self.hosts == 1 {
            return Some(Sender::new(program, settings));
        }
        let standing = self.standing();
        if self.protocol == Protocol::Marlin {
            assert!(!standing.entering);
            return Some(Sender::resuming(program, settings, &standing));
        }
        if !standing.began() {
            return Some(Sender::new(program, settings));
        }
        let places = standing.stands_at(&self.program, &settings, true)?;
        self.journal += &(Record::Anew.to_text() + &Record::Locating.to_text());
        Some(Sender::locating(program, settings, places, standing.paused.is_some()))
    }

    fn write_down(&mut self, sender: &mut Sender) {
        while let Some(event) = sender.next_event() {
            match event {
                Notice::Journal(record) => self.journal += &record.to_text(),
                Notice::Note(text) => self.told.push(format!("{:9.3}    {text}", self.now.as_secs_f64())),
                _ => {}
            }
        }
        let progress = sender.progress();
        if progress.proven != self.acked.0 && self.now >= self.acked.1 + GROUP {
            self.acked = (progress.proven, self.now);
            self.journal += &Record::Ack { number: progress.proven, block: progress.acked }.to_text();
        }
    }

    fn tell(&mut self, arrow: &str, bytes: &[u8]) {
        let text = String::from_utf8_lossy(bytes);
        self.told.push(format!("{:9.3} {arrow} {:?}", self.now.as_secs_f64(), text));
    }

    /// What the printer says reaches the port.
    fn listen(&mut self) {
        let bytes = self.sim.pending().to_vec();
        self.sim.took(bytes.len());
        self.port.extend_from_slice(&bytes);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        self.said.extend(text.lines().map(str::to_owned));
        let old = self.said.len().saturating_sub(40);
        self.said.drain(..old);
        for (_, logged) in self.sim.take_log() {
            if let Logged::Accepted(block) = logged {
                self.executed.push(without_padding(&String::from_utf8_lossy(&block)));
            }
        }
    }

    /// Lets one host talk until it ends or is killed.
    fn talk(&mut self, sender: &mut Sender, fate: Fate) -> End {
        let (mut bytes, mut fate) = (0, fate);
        let begun = self.now;
        if sender.wake(self.now).is_none() {
            sender.reconnected(self.now);
        }
        let mut back_at = None;
        loop {
            assert!(self.now < begun + BOUND, "no end\n{}", self.tail());
            self.sim.advance(self.now);
            if back_at.is_some_and(|at| at <= self.now) {
                back_at = None;
                sender.reconnected(self.now);
            }
            sender.poll(self.now);
            self.write_down(sender);
            let over = sender.outcome().cloned();
            let left = fate.killed.min(fate.reset).min(fate.unplugged) - bytes;
            let out =
                sender.pending()[..sender.pending().len().min(usize::try_from(left).unwrap_or(usize::MAX))].to_vec();
            sender.took(out.len());
            if !out.is_empty() {
                self.tell("->", &out);
                let late = std::mem::take(&mut self.late);
                self.port.extend_from_slice(&late);
            }
            self.sim.receive(self.now, &out);
            bytes += out.len() as u64;
            self.listen();
            let left = fate.killed.min(fate.reset).min(fate.unplugged) - bytes;
            let heard = self.port.len().min(usize::try_from(left).unwrap_or(usize::MAX));
            let back: Vec<u8> = self.port.drain(..heard).collect();
            if !back.is_empty() {
                self.tell("<-", &back);
            }
            sender.receive(self.now, &back);
            bytes += back.len() as u64;
            if bytes >= fate.killed {
                self.told.push("killed".to_owned());
                return End::Killed;
            }
            if bytes >= fate.reset {
                self.told.push("reset".to_owned());
                self.sim.restart(Duration::from_millis(self.numbers.between(100.0, 3000.0) as u64));
                fate.reset = NEVER;
            }
            if bytes >= fate.unplugged {
                self.told.push("unplugged".to_owned());
                sender.lost(self.now);
                self.sim.unplugged();
                self.port.clear();
                back_at = Some(self.now + Duration::from_secs(1));
                fate.unplugged = NEVER;
            }
            if let Some(outcome) = over.filter(|_| sender.pending().is_empty()) {
                return End::Over(outcome);
            }
            if out.is_empty() && back.is_empty() {
                let wakes = [sender.wake(self.now), self.sim.next_wake(), back_at];
                let next = wakes.into_iter().flatten().filter(|t| *t > self.now).min();
                self.now = next.unwrap_or(self.now + Duration::from_secs(1));
            }
        }
    }

    /// Between two hosts: the printer works on, and what it says stays in the port, or goes; some of what it has said before may come once more.
    fn alone(&mut self) {
        let until = self.now + Duration::from_secs_f64(self.numbers.between(0.0, 1.0).powi(3) * 4.0);
        self.now = until;
        self.sim.advance(until);
        self.listen();
        if self.numbers.between(0.0, 1.0) < 0.3 {
            self.port.clear();
        }
        for late in [false, true] {
            if self.numbers.between(0.0, 1.0) < 0.4 {
                let old = self.numbers.between(0.0, self.said.len() as f64) as usize;
                let stale: String = self.said[old..].iter().filter(|l| stale(l)).map(|l| format!("{l}\n")).collect();
                if late { self.late = stale.into_bytes() } else { self.port.extend_from_slice(stale.as_bytes()) }
            }
        }
    }

    /// Of `lines` those that must be executed once: all but our own on a printer that counts. Another one is set up anew, if need be, where it stands.
    fn once(&self, lines: &[String]) -> Vec<String> {
        let own = ["M105", "M110", "M115", "M400", "G4P0.01", "M114", "$H"];
        let counts = self.protocol == Protocol::Marlin;
        // Where half a line is carried out with the next host's first, its place tells whether it was the whole.
        let whole = |l: &str| l.starts_with("G1X") && !l[1..].contains(['F', 'G', 'M']);
        let is = |l: &&String| if counts { !own.iter().any(|o| l.starts_with(o)) } else { whole(l) };
        lines.iter().filter(is).cloned().collect()
    }

    fn tail(&self) -> String {
        let lines = &self.told[self.told.len().saturating_sub(120)..];
        format!("{}\njournal:\n{}", lines.join("\n"), self.journal)
    }
}

/// Whether a line may be an answer that somebody has not read: a death or a birth is news.
fn stale(line: &str) -> bool {
    !["start", "Marlin", "echo:", "Grbl", "RepRapFirmware", "// Klipper", "!!"].iter().any(|w| line.starts_with(w))
        && !line.contains("kill")
}

/// Grbl's machine is homed first.
fn link_time(protocol: Protocol) -> Duration {
    if protocol == Protocol::Grbl { Duration::from_secs(30) } else { Duration::ZERO }
}

/// What may happen in a run.
#[derive(Clone, Copy, Debug)]
struct Dangers {
    resets: bool,
    faults: bool,
    unplugs: bool,
}

/// One print by as many hosts as it takes; how it has ended, in a word.
fn run(protocol: Protocol, seed: u64, quirks: Quirks, dangers: Dangers) -> String {
    let mut numbers = Numbers::seeded(seed);
    let mut sometimes = |share: f64| numbers.between(0.0, 1.0) < share;
    let baud = [0, 115_200, 250_000][(seed % 3) as usize];
    let latency = Duration::from_millis(if sometimes(0.5) { 0 } else { 4 });
    let loop_time =
        if protocol == Protocol::Marlin && sometimes(0.5) { Duration::from_micros(500) } else { Duration::ZERO };
    let quirks = Quirks { baud, latency, loop_time, busy: sometimes(0.7), ..quirks };
    let script = if dangers.faults { Script::random(&SURVIVABLE, 0.004, seed) } else { Script::none() };
    let mut bench = Bench::new(protocol, seed, quirks, script, 60);
    let hosts = numbers.between(1.0, 7.0) as u64;
    for host in 1..=hosts {
        let Some(mut sender) = bench.host() else { return "no way to go on".to_owned() };
        // Early in the conversation, where a host asks, or anywhere in the print.
        let bytes = |share: f64, numbers: &mut Numbers| {
            let reach = if numbers.between(0.0, 1.0) < 0.6 { 700.0 } else { 6000.0 };
            if numbers.between(0.0, 1.0) < share { numbers.between(1.0, reach) as u64 } else { NEVER }
        };
        let fate = Fate {
            killed: if host == hosts { NEVER } else { bytes(1.0, &mut numbers) },
            reset: if dangers.resets { bytes(0.15, &mut numbers) } else { NEVER },
            unplugged: if dangers.unplugs { bytes(0.2, &mut numbers) } else { NEVER },
        };
        match bench.talk(&mut sender, fate) {
            End::Killed => bench.alone(),
            End::Over(outcome) => return judged(&mut bench, seed, &outcome, dangers),
        }
    }
    unreachable!("the last host is not killed")
}

/// Everything once, or a beginning and a reason.
fn judged(bench: &mut Bench, seed: u64, outcome: &Outcome, dangers: Dangers) -> String {
    bench.now += Duration::from_secs(600);
    bench.sim.advance(bench.now);
    bench.listen();
    let (wanted, mut done) = (bench.once(&blocks(&bench.program)), bench.once(&bench.executed));
    let differ = |done: &[String]| wanted.iter().zip(done).find(|(w, d)| w != d).map(|(w, d)| (w.clone(), d.clone()));
    let print = std::panic::AssertUnwindSafe(|| match outcome {
        Outcome::Done => {
            assert!(wanted == done, "{} wanted, {} executed: {:?}", wanted.len(), done.len(), differ(&done))
        }
        Outcome::Stopped(why) => {
            let expected = dangers.resets || dangers.faults || bench.protocol != Protocol::Marlin;
            assert!(expected, "stopped though nobody but hosts has died: {why}");
            while done.last().is_some_and(|l| l == "M104S0" || l == "M140S0") {
                done.pop();
            }
            assert!(wanted.starts_with(&done), "{:?}", differ(&done));
        }
        other => panic!("{other:?}"),
    });
    if let Err(why) = std::panic::catch_unwind(print) {
        note(&format!("seed {seed}, {:?}, {outcome:?}:\n{}", bench.protocol, bench.tail()));
        std::panic::resume_unwind(why);
    }
    let name = format!("{outcome:?}");
    name.split(['{', '"']).next().unwrap_or_default().trim().to_owned()
}

/// All seeds of one kind; how they have ended.
fn all(
    what: &str,
    protocol: Protocol,
    kind: impl Fn(&mut Quirks),
    dangers: Dangers,
    few: u64,
    many: u64,
) -> BTreeMap<String, u32> {
    let mut ends = BTreeMap::new();
    let seeds = seeds(few, many);
    for seed in seeds.clone() {
        let mut quirks = Quirks::of(protocol);
        kind(&mut quirks);
        *ends.entry(run(protocol, seed, quirks, dangers)).or_insert(0) += 1;
    }
    note(&format!("{what}, seeds {seeds:?}: {ends:?}"));
    ends
}

/// A firmware's name, and how it differs.
type Kind = (&'static str, fn(&mut Quirks));

const HOSTS: Dangers = Dangers { resets: false, faults: false, unplugs: true };
const ANYTHING: Dangers = Dangers { resets: true, faults: true, unplugs: true };

#[test]
fn hosts_killed_at_any_byte_lose_no_line_of_a_marlin_and_double_none() {
    let kinds: [Kind; 4] = [
        ("Marlin", |_| {}),
        ("Marlin 1.1, which refuses doubles", Quirks::marlin_1_1),
        ("Repetier's words", |q| (q.repetier_errors, q.silent_duplicates) = (true, false)),
        ("a firmware that repeats nothing", |q| q.repeats = false),
    ];
    for (name, kind) in kinds {
        let ends = all(name, Protocol::Marlin, kind, HOSTS, 60, 2500);
        assert!(ends.len() == 1 && ends.contains_key("Done"), "{name}: {ends:?}");
    }
}

#[test]
fn whatever_dies_at_any_byte_a_marlin_executes_each_line_once_or_the_print_stops() {
    let ends = all("Marlin, with resets and a bad wire", Protocol::Marlin, |_| {}, ANYTHING, 80, 3000);
    assert!(ends.contains_key("Done") && ends.len() > 1, "{ends:?}");
}

#[test]
fn whatever_dies_at_any_byte_of_a_printer_that_does_not_count_each_line_is_executed_once_or_the_print_stops() {
    for protocol in [Protocol::RepRapFirmware, Protocol::Klipper, Protocol::Grbl] {
        let ends = all(protocol.name(), protocol, |_| {}, HOSTS, 40, 1000);
        assert!(ends.contains_key("Done"), "{protocol:?}: {ends:?}");
    }
}

/// The number that the printer is asked with is none that it takes: an earlier host's count may be wrong by any of its last lines.
#[test]
fn a_question_is_never_a_line() {
    let program = program(Protocol::Marlin, &text(Protocol::Marlin, 60));
    let journal = Header::default().to_text() + "run 1 0\nrun 2 0\nrun 3 0\nack 2 0\nrun 35 32\nack 34 32\n";
    let standing = JournalSummary::parse(&journal).unwrap();
    let mut sender = Sender::resuming(Arc::clone(&program), settings(Protocol::Marlin), &standing);
    sender.reconnected(Duration::ZERO);
    let (mut now, mut asked) = (Duration::ZERO, Vec::new());
    while sender.outcome().is_none() {
        sender.poll(now);
        let text = String::from_utf8_lossy(sender.pending()).into_owned();
        asked.extend(text.lines().filter(|l| l.starts_with('N')).map(|l| {
            let number = l[1..].split(|c: char| !c.is_ascii_digit()).next().unwrap();
            number.parse::<i64>().unwrap()
        }));
        sender.took(sender.pending().len());
        now += Duration::from_millis(100);
    }
    assert!(matches!(sender.outcome(), Some(Outcome::Stopped(StopReason::Mute { .. }))), "{:?}", sender.outcome());
    assert!(asked.len() > 5 && asked.iter().all(|n| *n > 5000 && (*n & 0xffff) > 5000), "{asked:?}");
}
