//! Single lines to the printer behind Moonraker, and where it stands.
//!
//! A request returns once its line was carried out (moves: once they are in the queue), or with Klipper's own words where it was refused.
//! Source: moonraker.readthedocs.io, "Run a gcode"; Klipper's "Status reference" (`gcode_move`, `extruder`).

use serde_json::Value;

use super::address::Kind;
use super::api::State;
use super::configuration::Inquiry;
use super::fault::{PublishError, ServerFault};
use super::line::{Line, Question, escaped};
use super::moonraker::state;
use super::web::Web;

/// A printer behind a server that takes lines.
pub struct ServerConsole<'a> {
    line: Line<'a>,
}

impl<'a> ServerConsole<'a> {
    /// The printer behind a server, where it stands idle.
    ///
    /// # Errors
    ///
    /// [`ServerFault::NotIdle`] for one that does not; [`ServerFault::NoConsole`] for another server than Moonraker.
    pub fn open(asked: &Inquiry<'a>, web: &'a dyn Web) -> Result<Self, PublishError> {
        let console = Self { line: Line { to: asked.reached(), web } };
        let ready = || match asked.address.kind {
            Kind::Moonraker => match state(&console.line)? {
                State::Ready => Ok(()),
                State::Printing(file) => {
                    let why = format!("it prints {}", file.unwrap_or_else(|| "a file".to_owned()));
                    Err(ServerFault::NotIdle { why })
                }
                State::NotReady(why) => Err(ServerFault::NotIdle { why }),
            },
            _ => Err(ServerFault::NoConsole),
        };
        ready().map_err(|fault| console.told(fault))?;
        Ok(console)
    }

    /// Runs a line of G-code, once.
    ///
    /// # Errors
    ///
    /// [`ServerFault::Refused`] with Klipper's words; what was lost on the way may have been carried out.
    pub fn run(&self, line: &str) -> Result<(), PublishError> {
        let path = format!("/printer/gcode/script?script={}", escaped(line));
        let answer = self.line.once(Question::post(path, "application/json", Vec::new()), &|_| {});
        let done = answer.and_then(|answer| self.line.good("the line", answer));
        done.map(drop).map_err(|fault| self.told(fault))
    }

    /// X, Y and Z as lines count them, mm.
    ///
    /// # Errors
    ///
    /// Where it does not say.
    pub fn position(&self) -> Result<[f64; 3], PublishError> {
        let at = self.status("gcode_move", "gcode_position")?;
        let each = |i: usize| at[i].as_f64();
        let all = each(0).zip(each(1)).zip(each(2)).map(|((x, y), z)| [x, y, z]);
        all.ok_or_else(|| self.page())
    }

    /// The nozzle's temperature and what it shall become, degrees Celsius.
    ///
    /// # Errors
    ///
    /// Where it does not say.
    pub fn nozzle(&self) -> Result<[f64; 2], PublishError> {
        let number = |key| Ok(self.status("extruder", key)?.as_f64());
        number("temperature")?.zip(number("target")?).map(|(now, wanted)| [now, wanted]).ok_or_else(|| self.page())
    }

    fn status(&self, object: &str, key: &str) -> Result<Value, PublishError> {
        let told = self.line.read(WHAT, &format!("/printer/objects/query?{object}={key}"));
        Ok(told.map_err(|fault| self.told(fault))?["status"][object][key].clone())
    }

    fn page(&self) -> PublishError {
        self.told(ServerFault::Page { what: WHAT, kind: self.line.to.address.kind })
    }

    fn told(&self, fault: ServerFault) -> PublishError {
        PublishError::new(self.line.to.address, fault, false)
    }
}

const WHAT: &str = "the request for the printer";
