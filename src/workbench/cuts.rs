//! The chosen cuts by the parts that they are of. A part's number is the plan's: parts of the first model first, all copies of a model one after the
//! other. Words of cuts are as `--cut` has them, and stay as they are written.

/// Where parts come from: a model of the project, by its number there, its copies, and how many parts each has, where that is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct CountedModel {
    pub(super) id: u64,
    pub(super) copies: usize,
    pub(super) parts: Option<usize>,
}

/// The chosen cuts of one part of a model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct CutsOfPart {
    /// Which of the models.
    pub(super) model: usize,
    /// Which part of it; `None` where it has no other.
    pub(super) part: Option<usize>,
    /// The part's number in the plan, of the first copy; `None` where there is no other part.
    pub(super) number: Option<usize>,
    /// Which of all chosen cuts each is, and its words without the part.
    pub(super) cuts: Vec<(usize, String)>,
}

/// The words of a list of cuts; none for what is left to the plan.
fn words(cuts: &str) -> impl Iterator<Item = &str> {
    cuts.split(';').filter(|cut| !cut.is_empty() && *cut != "auto")
}

/// The part that a cut names, and the words behind it.
fn read(cut: &str) -> Option<(Option<usize>, &str)> {
    match cut.split_once(':') {
        Some((part, rest)) => Some((Some(part.parse().ok()?), rest)),
        None => Some((None, cut)),
    }
}

/// Whether there is more than one part, copies aside.
fn are_several(models: &[CountedModel]) -> bool {
    models.len() > 1 || models.first().is_some_and(|model| model.parts.is_some_and(|parts| parts > 1))
}

/// The model and its part that has a number; without one the only one has it.
fn place(number: Option<usize>, models: &[CountedModel]) -> Option<(usize, usize)> {
    let Some(number) = number else { return (!are_several(models)).then_some((0, 0)) };
    let mut first = 0;
    for (index, model) in models.iter().enumerate() {
        let parts = model.parts?;
        if number < first + parts * model.copies {
            return Some((index, (number - first) % parts));
        }
        first += parts * model.copies;
    }
    None
}

/// The number of a part of a model, of its first copy.
fn number((index, part): (usize, usize), models: &[CountedModel]) -> Option<usize> {
    let before: Option<usize> = models[..index].iter().map(|model| Some(model.parts? * model.copies)).sum();
    Some(before? + part)
}

/// The chosen cuts, those of a part together; `None` where one is of no part that is known.
pub(super) fn by_part(cuts: &str, models: &[CountedModel]) -> Option<Vec<CutsOfPart>> {
    let mut all: Vec<CutsOfPart> = Vec::new();
    for (which, cut) in words(cuts).enumerate() {
        let (named, rest) = read(cut)?;
        let at = place(named, models)?;
        let part = models[at.0].parts.filter(|parts| *parts > 1).map(|_| at.1);
        let known = all.iter().position(|one| (one.model, one.part) == (at.0, part));
        let known = known.unwrap_or_else(|| {
            let number = number(at, models).filter(|_| are_several(models));
            all.push(CutsOfPart { model: at.0, part, number, cuts: Vec::new() });
            all.len() - 1
        });
        all[known].cuts.push((which, rest.to_owned()));
    }
    Some(all)
}

/// The same cuts of the same parts where models were added, removed or copied; those of what is not there any more, or not known, are left out.
pub(super) fn renumbered(cuts: &str, before: &[CountedModel], after: &[CountedModel]) -> String {
    let again = |cut: &str| {
        let (named, rest) = read(cut)?;
        let (model, part) = place(named, before)?;
        let model = after.iter().position(|one| one.id == before[model].id)?;
        let number = number((model, part), after)?;
        Some(if are_several(after) { format!("{number}:{rest}") } else { rest.to_owned() })
    };
    let kept: Vec<String> = words(cuts).filter_map(again).collect();
    if kept.is_empty() { "auto".to_owned() } else { kept.join(";") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted(models: &[(u64, usize, usize)]) -> Vec<CountedModel> {
        models.iter().map(|&(id, copies, parts)| CountedModel { id, copies, parts: Some(parts) }).collect()
    }

    #[test]
    fn cuts_are_sorted_by_parts_and_copies_are_one() {
        let models = counted(&[(7, 2, 1), (8, 1, 3), (9, 2, 2)]);
        // 0 and 1 are the copies, 2 to 4 the second model, 5 and 6 the third, 7 and 8 its copy.
        let cuts = "1:1,0,0,5;3:0,0,1,2;0:1,0,0,9;8:0,1,0,1@1,2,3;6:0,1,0,2.50";
        let found = by_part(cuts, &models).unwrap();
        let told: Vec<_> = found.iter().map(|one| (one.model, one.part, one.number, one.cuts.len())).collect();
        assert_eq!(told, [(0, None, Some(0), 2), (1, Some(1), Some(3), 1), (2, Some(1), Some(6), 2)]);
        assert_eq!(found[2].cuts, [(3, "0,1,0,1@1,2,3".to_owned()), (4, "0,1,0,2.50".to_owned())]);
        for bad in ["9:1,0,0,5", "1,0,0,5", "x:1,0,0,5"] {
            assert_eq!(by_part(bad, &models), None, "{bad}");
        }
        let one = by_part("1,0,0,5;0:1,0,0,2", &counted(&[(7, 3, 1)])).unwrap();
        assert_eq!((one.len(), one[0].number, one[0].cuts.len()), (1, None, 2));
        assert_eq!(by_part("auto", &models), Some(Vec::new()));
    }

    #[test]
    fn cuts_stay_with_their_parts() {
        let one = counted(&[(7, 1, 1)]);
        let with_another = [one[0], CountedModel { id: 8, copies: 1, parts: None }];
        assert_eq!(renumbered("1,0,0,5;1,0,0,2@1,2,3", &one, &with_another), "0:1,0,0,5;0:1,0,0,2@1,2,3");
        let (both, more) = (counted(&[(7, 1, 1), (8, 1, 2)]), counted(&[(7, 4, 1), (8, 1, 2)]));
        assert_eq!(renumbered("0:1,0,0,5;2:0,0,1,2.50", &both, &more), "0:1,0,0,5;5:0,0,1,2.50");
        assert_eq!(renumbered("0:1,0,0,5;5:0,0,1,2.50", &more, &both), "0:1,0,0,5;2:0,0,1,2.50");
        // One of them goes.
        assert_eq!(renumbered("0:1,0,0,5;2:0,0,1,2", &both, &counted(&[(8, 1, 2)])), "1:0,0,1,2");
        assert_eq!(renumbered("0:1,0,0,5;2:0,0,1,2", &both, &one), "1,0,0,5");
        assert_eq!(renumbered("2:0,0,1,2", &both, &one), "auto");
        // Nobody knows how many parts the first has.
        let unknown = [CountedModel { parts: None, ..both[0] }, both[1]];
        assert_eq!(renumbered("1:0,0,1,2", &unknown, &both), "auto");
    }
}
