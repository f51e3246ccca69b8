//! What is typed at one screen for several prints, which are called by their numbers from 1.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::Answer;

/// What can be typed.
const WORDS: &str =
    "use N (continue), Enter (continue all), p N (pause), c N (cancel a paused print), s N (emergency stop)";

/// What is asked of one print.
#[derive(Clone, Copy, Debug, Default)]
struct Asked {
    paused: bool,
    answer: Option<Answer>,
    interrupts: u32,
    /// It has paused by itself: the first Ctrl-C, which is to pause all, finds it so.
    paused_itself: bool,
}

/// What was typed for whom.
#[derive(Debug)]
pub struct Desk {
    prints: Mutex<Vec<Asked>>,
    open: AtomicBool,
}

impl Desk {
    /// Of so many prints; where nobody can type it is not `open`.
    pub fn new(prints: usize, open: bool) -> Self {
        Self { prints: Mutex::new(vec![Asked::default(); prints]), open: AtomicBool::new(open) }
    }

    fn prints(&self) -> MutexGuard<'_, Vec<Asked>> {
        self.prints.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A line that was typed.
    ///
    /// # Errors
    ///
    /// What could have been typed, where it means nothing.
    pub fn typed(&self, line: &str) -> Result<(), String> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let mut prints = self.prints();
        let of = prints.len();
        let number = |text: &str| text.parse::<usize>().ok().filter(|n| (1..=of).contains(n)).map(|n| n - 1);
        let wrong = || format!("unknown command {:?}; {WORDS}, N from 1 to {of}", line.trim());
        let (order, print) = match words.as_slice() {
            [] => {
                prints.iter_mut().filter(|p| p.paused).for_each(|p| p.answer = Some(Answer::Continue));
                return Ok(());
            }
            [print] => ("", number(print).ok_or_else(wrong)?),
            [order, print] => (*order, number(print).ok_or_else(wrong)?),
            _ => return Err(wrong()),
        };
        let asked = &mut prints[print];
        match order {
            "" | "c" if !asked.paused => return Err(format!("print {} is not paused", print + 1)),
            "" => asked.answer = Some(Answer::Continue),
            "c" => asked.answer = Some(Answer::Cancel),
            "p" if asked.interrupts > 0 || asked.paused => {
                return Err(format!("print {} is already pausing", print + 1));
            }
            "p" => asked.interrupts = 1,
            // As Ctrl-C twice.
            "s" => asked.interrupts += 2,
            _ => return Err(wrong()),
        }
        Ok(())
    }

    /// Nothing more will be typed.
    pub fn close(&self) {
        self.open.store(false, Ordering::SeqCst);
    }

    /// `print` is paused, after so many Ctrl-C.
    pub fn pauses(&self, print: usize, ctrl_c: u32) {
        let asked = &mut self.prints()[print];
        asked.paused = true;
        asked.paused_itself = asked.interrupts == 0 && ctrl_c == 0;
    }

    /// What is to become of `print`, which is paused.
    pub fn answer(&self, print: usize) -> Answer {
        let answer = self.prints()[print].answer.take();
        let silent = if self.open.load(Ordering::SeqCst) { Answer::NotYet } else { Answer::Nobody };
        answer.unwrap_or(silent)
    }

    /// How often `print` was asked to end, after so many Ctrl-C: one is to pause all that are not paused, two stop every one.
    pub fn interrupts(&self, print: usize, ctrl_c: u32) -> u32 {
        let asked = &self.prints()[print];
        asked.interrupts.max(ctrl_c.saturating_sub(asked.paused_itself.into()))
    }

    /// A pause is over.
    pub fn forget(&self, print: usize) {
        self.prints()[print] = Asked::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_order_reaches_its_print_and_no_other() {
        let desk = Desk::new(3, true);
        desk.typed("p 2").unwrap();
        desk.typed("s 3").unwrap();
        assert_eq!([0, 1, 2].map(|i| desk.interrupts(i, 0)), [0, 1, 2]);
        for i in [0, 1] {
            desk.pauses(i, 0);
        }
        desk.typed(" 2 ").unwrap();
        assert_eq!([0, 1, 2].map(|i| desk.answer(i)), [Answer::NotYet, Answer::Continue, Answer::NotYet]);
        desk.typed("").unwrap();
        assert_eq!([0, 1, 2].map(|i| desk.answer(i)), [Answer::Continue, Answer::Continue, Answer::NotYet]);
        desk.typed("c 1").unwrap();
        assert_eq!((desk.answer(0), desk.answer(0)), (Answer::Cancel, Answer::NotYet));
        desk.forget(1);
        assert_eq!((desk.interrupts(1, 0), desk.interrupts(2, 0)), (0, 2));
        desk.close();
        assert_eq!(desk.answer(0), Answer::Nobody);
    }

    #[test]
    fn what_means_nothing_is_told_and_does_nothing() {
        let desk = Desk::new(2, true);
        for wrong in ["0", "3", "x", "c", "s s", "s 1 2", "-1", "q 1"] {
            assert!(desk.typed(wrong).unwrap_err().contains("N from 1 to 2"), "{wrong}");
        }
        assert_eq!(desk.typed("1").unwrap_err(), "print 1 is not paused");
        assert_eq!(desk.typed("c 2").unwrap_err(), "print 2 is not paused");
        desk.typed("p 1").unwrap();
        assert!(desk.typed("p 1").is_err());
        assert_eq!([0, 1].map(|i| (desk.interrupts(i, 0), desk.answer(i))), [(1, Answer::NotYet), (0, Answer::NotYet)]);
    }

    /// What Ctrl-C means to one that runs, that was asked to pause alone, and that has paused by itself; before and behind its pause.
    #[test]
    fn ctrl_c_once_pauses_whoever_is_not_paused_and_twice_stops_all() {
        let counts = |desk: &Desk, print| [0, 1, 2].map(|ctrl_c| desk.interrupts(print, ctrl_c));
        let desk = Desk::new(3, true);
        desk.typed("p 2").unwrap();
        assert_eq!([0, 1, 2].map(|print| counts(&desk, print)), [[0, 1, 2], [1, 1, 2], [0, 1, 2]]);
        desk.pauses(1, 0);
        desk.pauses(2, 0);
        assert_eq!([1, 2].map(|print| counts(&desk, print)), [[1, 1, 2], [0, 0, 1]]);
        // Paused by the first Ctrl-C.
        desk.pauses(0, 1);
        assert_eq!(counts(&desk, 0), [0, 1, 2]);
        desk.forget(2);
        assert_eq!(counts(&desk, 2), [0, 1, 2]);
        desk.typed("s 2").unwrap();
        assert_eq!(counts(&desk, 1), [3, 3, 3]);
    }
}
