//! The log from which an interrupted print is resumed: text, one record a line, appended; none is ever changed.
//!
//! ```text
//! trunnion-journal 1
//! file <sha256> <bytes> <path>
//! profile <sha256> <name>
//! device <identity of the port>
//! printer <what M115 says>
//! boot <the host's boot>
//! run <number> <block>     from this number on, numbers carry blocks from this one on
//! ack <number> <block>     lines up to this number are proven accepted; blocks before this one are answered
//! entering                 the machine is homed and brought to the part anew, from the beginning of that until `back`
//! locating                 the printer is asked where it stands; none of the file's lines goes out until `back`
//! anew                     numbers begin again, and the position of the machine is unknown
//! away | back              the head has left the part | is back
//! paused <block>           it is away, every block before this one is executed and none from it on was sent
//! sent <block>             no block from this one on was sent: the last word of a host that ended in order
//! done | stopped <why>
//! ```
//!
//! `run` records are written before the lines they speak of are sent; `ack` records in groups, so that the last may be
//! missing: they are lower bounds. `entering` comes before its `anew`, so that an end that is torn between the two never looks
//! like a print whose printer still counts: until `back` the re-entry is repeated from its start. A last line without
//! its newline was cut short and counts for nothing, and so does everything from the first zero byte on: room that is kept for
//! what a pause must still write on a full disk.

/// What identifies a job.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// Of the file as sent.
    pub sha256: String,
    /// Its size.
    pub bytes: u64,
    /// Where it was.
    pub path: String,
    /// Of the resolved profile.
    pub profile_sha256: String,
    /// The profile's name.
    pub profile: String,
    /// The port's identity.
    pub device: String,
    /// The host's boot, from which the operating system's buffers date.
    pub boot: String,
}

/// One line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Record {
    /// Numbers from `number` on carry blocks from `block` on.
    Run {
        /// On the wire.
        number: i64,
        /// Of the program.
        block: u32,
    },
    /// Lines up to `number` are proven accepted, blocks before `block` are answered.
    Ack {
        /// On the wire.
        number: i64,
        /// Of the program.
        block: u32,
    },
    /// What the printer calls itself.
    Printer(String),
    /// The machine is homed and brought to the part anew; until [`Record::Back`] nothing of that counts as done.
    Entering,
    /// The printer is asked where it stands; no block goes out until [`Record::Back`].
    Locating,
    /// Numbers begin again.
    Anew,
    /// The head has left, or is leaving, the part.
    Away,
    /// It is back.
    Back,
    /// The head is away, every block before this one is executed, none from it on was sent.
    Paused(u32),
    /// No block from this one on was sent.
    Sent(u32),
    /// The program has ended.
    Done,
    /// It was stopped.
    Stopped(String),
}

/// What a journal knows in the end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct JournalSummary {
    /// The job.
    pub header: Header,
    /// The printer's words.
    pub printer: String,
    /// Lines up to this number are accepted.
    pub proven: i64,
    /// Blocks before this one are answered, under whichever numbers; more may be.
    pub answered: u32,
    /// Blocks before this one, and those up to the next proof, may have been printed at some time: numbers that begin anew
    /// leave what is printed where it is.
    pub reach: u32,
    /// Whether the head was away from the part.
    pub away: bool,
    /// In a pause that was reached: every block before this one is executed, none from it on was sent. Holds until the head is back.
    pub paused: Option<u32>,
    /// No block from this one on was sent, where the host lived to say so and has sent none since.
    pub sent: Option<u32>,
    /// What a re-entry may have left behind it beyond its own place: blocks before this one.
    pub stood: u32,
    /// Blocks before this one are not printed again: here the print went on after a pause or a re-entry.
    pub resumed_at: u32,
    /// Whether a re-entry after a reset was begun and not ended.
    pub entering: bool,
    /// Whether the program ended.
    pub done: bool,
    runs: Vec<(i64, u32)>,
    locating: bool,
    /// Whether a line was ever numbered.
    numbered: bool,
}

/// Why a journal cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, strum::IntoStaticStr)]
#[strum(serialize_all = "kebab-case", prefix = "journal/")]
pub enum JournalError {
    /// Not one of ours.
    #[error(
        "not a journal of trunnion send (its first line must be \"trunnion-journal 1\"); pass the right file with --journal"
    )]
    Foreign,
    /// A line that no version of ours writes.
    #[error("line {line} of the journal cannot be read: {text:?}")]
    Broken {
        /// From 1.
        line: usize,
        /// Its text.
        text: String,
    },
    /// A journal that is damaged, or of another program.
    #[error("the journal names block {block}, but the program has {blocks}, so it is damaged; start the print again")]
    Beyond {
        /// From 0.
        block: u32,
        /// Of the program.
        blocks: u32,
    },
}

const FIRST: &str = "trunnion-journal 1";

/// Lines of our own that may be numbered and have no `run` record: none today.
const UNTOLD: i64 = 1000;

impl Header {
    /// The journal's beginning.
    pub fn to_text(&self) -> String {
        let Self { sha256, bytes, path, profile_sha256, profile, device, boot } = self;
        let one = |text: &str| text.replace(['\n', '\r'], " ");
        format!(
            "{FIRST}\nfile {sha256} {bytes} {}\nprofile {profile_sha256} {}\ndevice {}\nboot {}\n",
            one(path),
            one(profile),
            one(device),
            one(boot)
        )
    }
}

impl Record {
    /// The record's line, newline included.
    pub fn to_text(&self) -> String {
        match self {
            Self::Run { number, block } => format!("run {number} {block}\n"),
            Self::Ack { number, block } => format!("ack {number} {block}\n"),
            Self::Printer(text) => format!("printer {}\n", text.replace(['\n', '\r'], " ")),
            Self::Entering => "entering\n".to_owned(),
            Self::Locating => "locating\n".to_owned(),
            Self::Anew => "anew\n".to_owned(),
            Self::Away => "away\n".to_owned(),
            Self::Back => "back\n".to_owned(),
            Self::Paused(block) => format!("paused {block}\n"),
            Self::Sent(block) => format!("sent {block}\n"),
            Self::Done => "done\n".to_owned(),
            Self::Stopped(why) => format!("stopped {}\n", why.replace(['\n', '\r'], " ")),
        }
    }
}

impl JournalSummary {
    /// Reads a journal.
    ///
    /// # Errors
    ///
    /// [`JournalError`] where a whole line is not one of ours.
    pub fn parse(text: &str) -> Result<Self, JournalError> {
        // Zeros are room kept for what a pause will write.
        let text = text.split('\0').next().unwrap_or_default();
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut lines = whole.lines();
        if lines.next() != Some(FIRST) {
            return Err(JournalError::Foreign);
        }
        let mut standing = Self::default();
        for (index, line) in lines.enumerate() {
            let broken = || JournalError::Broken { line: index + 2, text: line.to_owned() };
            standing.take(line).ok_or_else(broken)?;
        }
        Ok(standing)
    }

    fn take(&mut self, line: &str) -> Option<()> {
        let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
        let pair = || {
            let (a, b) = rest.split_once(' ')?;
            Some((a.parse::<i64>().ok()?, b.parse::<u32>().ok()?))
        };
        match word {
            "file" => {
                let mut words = rest.splitn(3, ' ');
                self.header.sha256 = words.next()?.to_owned();
                self.header.bytes = words.next()?.parse().ok()?;
                self.header.path = words.next()?.to_owned();
            }
            "profile" => {
                let (hash, name) = rest.split_once(' ')?;
                (self.header.profile_sha256, self.header.profile) = (hash.to_owned(), name.to_owned());
            }
            "device" => self.header.device = rest.to_owned(),
            "boot" => self.header.boot = rest.to_owned(),
            "printer" => self.printer = rest.to_owned(),
            "run" => {
                let (number, block) = pair()?;
                if !(1..=self.highest(block)).contains(&number) {
                    return None;
                }
                self.runs.retain(|(n, _)| *n < number);
                self.runs.push((number, block));
                self.numbered = true;
                self.reach = self.reach.max(block);
                // Until the head is back only lines of our own go out.
                let own = self.entering || self.away || self.locating;
                self.sent = self.sent.filter(|_| own);
            }
            "ack" => {
                let (number, block) = pair()?;
                if !(0..=self.highest(block)).contains(&number) {
                    return None;
                }
                // A re-entry that is interrupted takes nothing back of what was printed before it.
                (self.proven, self.answered) = (number, self.answered.max(block));
                self.reach = self.reach.max(block);
            }
            "anew" => {
                self.runs.clear();
                (self.proven, self.away) = (0, false);
            }
            "entering" => self.entering = true,
            "locating" => self.locating = true,
            "away" => self.away = true,
            "back" => {
                if self.entering {
                    self.stood = self.stood.max(self.paused.or(self.sent).unwrap_or(self.reach));
                }
                (self.away, self.entering, self.locating) = (false, false, false);
                (self.paused, self.sent) = (None, None);
                self.resumed_at = self.resumed_at.max(self.runs.last().map_or(0, |(_, block)| *block));
            }
            "paused" => self.paused = Some(rest.parse().ok()?),
            "sent" => self.sent = Some(rest.parse().ok()?),
            "done" => self.done = true,
            "stopped" => {}
            _ => return None,
        }
        Some(())
    }

    /// Looks whether it can be of a program of so many blocks.
    ///
    /// # Errors
    ///
    /// [`JournalError::Beyond`]. Whoever resumes asks this first.
    pub fn check(&self, blocks: u32) -> Result<(), JournalError> {
        let said = [Some(self.reach), Some(self.stood), Some(self.resumed_at), self.paused, self.sent];
        match said.into_iter().flatten().find(|block| *block > blocks) {
            Some(block) => Err(JournalError::Beyond { block, blocks }),
            None => Ok(()),
        }
    }

    /// The highest number that can have been given when `block` was reached: each carries a block or a line of our own, of which
    /// every one has its record. Whoever resumes keeps something for every number that may still be under way.
    fn highest(&self, block: u32) -> i64 {
        i64::from(block) + self.runs.len() as i64 + UNTOLD
    }

    /// The first block that is not accepted where the printer's last accepted line is `number`.
    pub fn next_block(&self, number: i64) -> u32 {
        let next = number.saturating_add(1);
        let run = self.runs.iter().rev().find(|(start, _)| *start <= next);
        // A run's number is at least 1.
        run.map_or(0, |(start, block)| block.saturating_add(u32::try_from(next - start).unwrap_or(u32::MAX)))
    }

    /// The block that line `number` carries; `None` for a line of our own.
    pub fn block_at(&self, number: i64) -> Option<u32> {
        let block = self.next_block(number.saturating_sub(1));
        (Some(self.next_block(number)) == block.checked_add(1)).then_some(block)
    }

    /// The highest number that can have been sent of a program of `blocks` by a host that proves its count `every` so many lines: each proof
    /// has its own record.
    pub fn last(&self, blocks: u32, every: u32) -> i64 {
        let run = |(number, block): &(i64, u32)| number + i64::from(blocks.saturating_sub(*block).min(every));
        self.runs.last().map_or(self.proven, run)
    }

    /// Whether any line was ever numbered, under these numbers or under earlier ones: something may stand on the table.
    pub fn began(&self) -> bool {
        self.entering || self.reach > 0 || self.numbered
    }

    /// Whether a counter that agrees is enough to go on: the machine is where the program has brought it, and not on the way
    /// there after a reset.
    pub fn counts(&self) -> bool {
        !self.entering && !self.runs.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal(records: &[Record]) -> JournalSummary {
        let header = Header { sha256: "ab".into(), bytes: 7, path: "a b.gcode".into(), ..Header::default() };
        let text: String = records.iter().map(Record::to_text).collect();
        JournalSummary::parse(&(header.to_text() + &text)).unwrap()
    }

    #[test]
    fn a_line_number_names_its_block() {
        // Lines 1 and 2 are ours, 3..=34 carry blocks 0..=31, 35 is ours, 36 on carries 32 on.
        let runs = [(2, 0), (3, 0), (36, 32)].map(|(number, block)| Record::Run { number, block });
        let standing =
            journal(&[runs[0].clone(), runs[1].clone(), Record::Ack { number: 2, block: 0 }, runs[2].clone()]);
        assert_eq!([1, 2, 3, 34, 35, 36].map(|n| standing.next_block(n)), [0, 0, 1, 32, 32, 33]);
        assert_eq!([2, 3, 34, 35, 36].map(|n| standing.block_at(n)), [None, Some(0), Some(31), None, Some(32)]);
        assert_eq!((standing.proven, standing.header.path.as_str()), (2, "a b.gcode"));
    }

    #[test]
    fn numbers_given_anew_after_a_break_take_the_place_of_the_old() {
        let run = |number, block| Record::Run { number, block };
        let standing = journal(&[run(3, 0), run(36, 32), run(21, 17), run(22, 17)]);
        assert_eq!([19, 20, 21, 22, 40].map(|n| standing.next_block(n)), [17, 17, 17, 18, 36]);
    }

    #[test]
    fn what_was_printed_before_a_re_entry_is_not_forgotten() {
        let run = |number, block| Record::Run { number, block };
        let first = [run(3, 0), run(36, 32), Record::Ack { number: 70, block: 60 }];
        let again = [Record::Anew, run(3, 20), Record::Ack { number: 9, block: 25 }];
        assert_eq!(journal(&first).reach, 60);
        let standing = journal(&[first.as_slice(), &again].concat());
        assert_eq!((standing.reach, standing.answered), (60, 60));
    }

    #[test]
    fn a_re_entry_that_has_not_ended_is_a_print_that_began_and_counts_for_nothing() {
        let run = |number, block| Record::Run { number, block };
        let printed = [run(3, 0), run(36, 32), Record::Ack { number: 70, block: 60 }, Record::Away];
        assert!(journal(&printed).began() && journal(&printed).counts());
        let entry = [Record::Entering, Record::Anew, run(2, 40), run(3, 40), Record::Ack { number: 9, block: 40 }];
        for cut in 1..=entry.len() {
            let standing = journal(&[&printed[..], &entry[..cut]].concat());
            assert!(standing.began() && !standing.counts() && standing.entering, "{cut}: {standing:?}");
            assert_eq!((standing.away, standing.answered, standing.reach), (cut < 2, 60, 60), "{cut}");
        }
        let ended = journal(&[&printed[..], &entry, &[Record::Back]].concat());
        assert!(ended.began() && ended.counts() && !ended.entering && !ended.away, "{ended:?}");
        // Numbers that begin anew in mid-print, cut before their first run.
        let anew = journal(&[&printed[..3], &[Record::Anew]].concat());
        assert!(anew.began() && !anew.counts(), "{anew:?}");
        assert!(!journal(&[]).began());
        // Before anything was answered.
        let asked = journal(&[run(2, 0), Record::Anew, Record::Locating]);
        assert!(asked.began() && !asked.counts(), "{asked:?}");
    }

    #[test]
    fn a_torn_end_counts_for_nothing_and_rubbish_is_named() {
        let text = Header::default().to_text() + "run 3 0\nack 9 6\nack 1";
        let standing = JournalSummary::parse(&text).unwrap();
        assert_eq!((standing.proven, standing.answered), (9, 6));
        assert_eq!(JournalSummary::parse(&(text + "\0\0\0ack 99 99\n")).unwrap(), standing);
        assert_eq!(JournalSummary::parse("G28\n"), Err(JournalError::Foreign));
        let broken = JournalSummary::parse(&(Header::default().to_text() + "nonsense\n"));
        assert!(matches!(broken, Err(JournalError::Broken { line: 6, .. })), "{broken:?}");
    }

    /// Each number carries a block or a line of our own that has its record; whoever resumes keeps something for each of them.
    #[test]
    fn a_number_that_nobody_can_have_given_is_a_broken_line() {
        let read = |records: &str| JournalSummary::parse(&(Header::default().to_text() + records));
        for broken in [
            "run 429496729570 60",
            "run 9223372036854775807 4294967295",
            "run 0 0",
            "run -9223372036854775808 5",
            "ack -1 0",
            "ack 9223372036854775807 0",
        ] {
            let error = JournalError::Broken { line: 7, text: broken.to_owned() };
            assert_eq!(read(&format!("run 3 0\n{broken}\n")), Err(error), "{broken}");
        }
        // A long re-entry that has not printed anything yet.
        let entry: String = (2..400).map(|number| format!("run {number} 70000\n")).collect();
        assert!(read(&format!("run 2 0\nack 71000 70000\nentering\nanew\n{entry}ack 399 70000\n")).is_ok());
        let standing = read("run 3 4294967295\nack 2 0\n").unwrap();
        assert_eq!([2, 3, 70, i64::MAX].map(|number| standing.next_block(number)), [u32::MAX; 4]);
        assert_eq!([i64::MIN, 2, i64::MAX].map(|number| standing.block_at(number)), [None; 3]);
        assert_eq!(standing.last(120, 32), 3);
        // Behind a run there are at most the lines up to the next proof.
        let standing = read("run 3 0\nack 2 0\n").unwrap();
        assert_eq!([standing.last(120, 32), standing.last(9, 32)], [35, 12]);
    }

    #[test]
    fn a_journal_of_more_than_the_program_is_refused() {
        let whole = [Record::Run { number: 3, block: 0 }, Record::Ack { number: 122, block: 120 }];
        let with = |more: &[Record]| journal(&[&whole[..], more].concat());
        for fits in [vec![], vec![Record::Away, Record::Paused(120)], vec![Record::Sent(120)]] {
            assert_eq!(with(&fits).check(120), Ok(()), "{fits:?}");
        }
        for (more, block) in [
            (vec![Record::Paused(482_840)], 482_840),
            (vec![Record::Sent(121)], 121),
            (vec![Record::Run { number: 130, block: 125 }], 125),
            (vec![Record::Ack { number: 123, block: 121 }], 121),
            (vec![Record::Entering, Record::Anew, Record::Paused(200), Record::Back], 200),
        ] {
            let error = with(&more).check(120).unwrap_err();
            assert_eq!(error, JournalError::Beyond { block, blocks: 120 });
        }
    }

    #[test]
    fn what_was_sent_holds_until_more_may_be_sent() {
        let run = |number, block| Record::Run { number, block };
        let ended = [run(3, 0), run(36, 32), Record::Ack { number: 70, block: 60 }, Record::Sent(64)];
        let with = |more: &[Record]| journal(&[&ended[..], more].concat());
        assert_eq!((with(&[]).sent, with(&[run(70, 60)]).sent), (Some(64), None));
        // Asking where it stands, and a re-entry, send nothing of the file.
        let asking = [Record::Anew, Record::Locating, run(2, 60)];
        assert_eq!(with(&asking).sent, Some(64));
        assert_eq!(with(&[&asking[..], &[Record::Back]].concat()).sent, None);
        let entering = [Record::Entering, Record::Anew, run(2, 50)];
        assert_eq!(with(&entering).sent, Some(64));
        // Behind it what stood before still stands.
        let back = with(&[&entering[..], &[Record::Back, Record::Sent(55)]].concat());
        assert_eq!((back.sent, back.stood, back.resumed_at), (Some(55), 64, 50));
        let paused = with(&[Record::Away, Record::Paused(61), Record::Entering, Record::Anew, run(2, 61)]);
        assert_eq!(paused.paused, Some(61));
        assert_eq!(with(&[Record::Away, Record::Paused(61), Record::Back]).paused, None);
    }

    #[test]
    fn away_and_done_are_remembered() {
        let standing =
            journal(&[Record::Away, Record::Back, Record::Away, Record::Done, Record::Stopped("a\nb".into())]);
        assert!(standing.away && standing.done);
    }
}
