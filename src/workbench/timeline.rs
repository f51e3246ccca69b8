//! The prints of a plan in their order, as the page shows them, and the command that asks whether another order can be printed. Pure values.

use serde_json::{Value, json};

use super::choices::{Choices, guarded, push};

/// A plan that the prints are shown of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Timeline {
    /// Everything that it depends on, as text.
    pub(super) made_of: String,
    /// The way that it is printed.
    pub(super) way: String,
    /// The file that the plan is of.
    file: String,
    prints: Value,
}

impl Timeline {
    /// That of a plan's `document`; `None` for what is none.
    pub(super) fn of(made_of: String, way: String, document: &Value) -> Option<Self> {
        let file = document["model"]["file"].as_str()?.to_owned();
        let prints = document["slots"].as_array()?.iter().flat_map(|slot| cards(slot, document)).collect();
        Some(Self { made_of, way, file, prints })
    }

    /// The words of the command that plans what is chosen in this order. Of a solid that was cut it plans the parts.
    pub(super) fn words(&self, choices: &Choices, order: &str) -> Vec<String> {
        let mut words = vec!["plan".to_owned()];
        let cut = self.way == "cut";
        words.extend(if cut { vec![guarded(&self.file)] } else { choices.words_of_models() });
        words.extend(["-m".to_owned(), choices.machine.clone().unwrap_or_default()]);
        if !cut {
            choices.push_reading(&mut words);
        }
        push(&mut words, "--finish", &choices.finish);
        push(&mut words, "--order", order);
        words
    }

    /// The prints as the page shows them.
    pub(super) fn document(&self) -> Value {
        json!({"way": self.way, "prints": self.prints})
    }
}

/// What is printed in one pose of a slot grows together: one card each.
fn cards(slot: &Value, document: &Value) -> Vec<Value> {
    let mut cards: Vec<Value> = Vec::new();
    for print in slot["prints"].as_array().into_iter().flatten() {
        let Some(part) = print["part"].as_u64() else { continue };
        let index = usize::try_from(part).unwrap_or(usize::MAX);
        let (name, seconds) =
            (&document["parts"][index]["name"], document["part_seconds"][index].as_f64().unwrap_or(0.0));
        let pose = ["tilt_deg", "rotation_deg"].map(|key| &print[key]);
        let same = |card: &&mut Value| [&card["tilt_deg"], &card["rotation_deg"]] == pose;
        if let Some(card) = cards.iter_mut().find(same) {
            card["parts"].as_array_mut().into_iter().for_each(|parts| parts.push(part.into()));
            card["names"].as_array_mut().into_iter().for_each(|names| names.push(name.clone()));
            card["seconds"] = (card["seconds"].as_f64().unwrap_or(0.0) + seconds).into();
            continue;
        }
        cards.push(json!({
            "parts": [part], "names": [name], "slot": slot["id"], "tilt_deg": pose[0], "rotation_deg": pose[1], "seconds": seconds,
        }));
    }
    cards
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan() -> Value {
        let print = |part: u32, tilt: f64| json!({"part": part, "tilt_deg": tilt, "rotation_deg": 0.0});
        json!({
            "model": {"file": "a.parts.3mf"}, "part_seconds": [60.0, 30.0, 20.0, 10.0],
            "parts": [{"name": "a"}, {"name": "b"}, {"name": "c"}, {"name": "d"}],
            "slots": [{"id": 0, "prints": [print(0, 0.0)]}, {"id": 1, "prints": [print(2, 45.0), print(1, -45.0), print(3, 45.0)]}],
        })
    }

    #[test]
    fn what_grows_together_is_one_card() {
        let timeline = Timeline::of(String::new(), "cut".to_owned(), &plan()).unwrap();
        let cards = timeline.document()["prints"].as_array().unwrap().clone();
        let parts: Vec<&Value> = cards.iter().map(|card| &card["parts"]).collect();
        assert_eq!(parts, [&json!([0]), &json!([2, 3]), &json!([1])]);
        assert_eq!(
            (&cards[1]["names"], &cards[1]["seconds"], &cards[1]["slot"]),
            (&json!(["c", "d"]), &json!(30.0), &json!(1))
        );
        assert!(Timeline::of(String::new(), String::new(), &json!({"error": "no"})).is_none());
    }

    #[test]
    fn the_parts_of_a_cut_are_asked_about_and_else_the_models() {
        let mut choices = Choices::new(Some("generic-ac".to_owned()));
        choices.set("unit", "cm", &[]).unwrap();
        choices.set("finish", "fine", &[]).unwrap();
        let words = |way: &str| {
            let timeline = Timeline::of(String::new(), way.to_owned(), &plan()).unwrap();
            timeline.words(&choices, "0,2+3,1")
        };
        let end = ["--finish", "fine", "--order", "0,2+3,1"];
        assert_eq!(words("cut"), [&["plan", "a.parts.3mf", "-m", "generic-ac"][..], &end].concat());
        assert_eq!(words("as-drawn"), [&["plan", "-m", "generic-ac", "--unit", "cm"][..], &end].concat());
    }
}
