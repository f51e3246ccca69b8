//! A travel through what the same print has laid, from nothing to gross.

use super::{Rule, changed, profile, run};

/// The post with a travel across it and back, so much lower than the layer that is being laid.
fn crossing(deep_mm: f64, to: [f64; 2]) -> String {
    const MARK: &str = ";TYPE:Solid infill";
    let text = changed(MARK, 60, ";HERE");
    let before: Vec<&str> = text.split(";HERE").next().unwrap().lines().collect();
    let word = |letter: char| {
        let of = |line: &&str| line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse::<f64>().ok());
        before.iter().rev().filter(|line| line.starts_with("G1 ")).find_map(of).unwrap()
    };
    let [x, y, z] = ['X', 'Y', 'Z'].map(word);
    let low = z - deep_mm;
    let way = format!(
        "G1 Z{low:.3} F900\nG1 X{:.3} Y{:.3} F6000\nG1 X{x:.3} Y{y:.3} F6000\nG1 Z{z:.3} F900\n{MARK}",
        to[0], to[1]
    );
    text.replacen(";HERE", &way, 1)
}

#[test]
fn a_travel_keeps_out_of_what_its_own_print_has_laid() {
    // Lines give way to the nozzle by 0.425 mm where one is laid; what went through them by less was let pass.
    for (deep, found) in
        [(0.0, false), (0.03, false), (0.049, false), (0.06, true), (0.1, true), (0.2, true), (0.4, true), (0.8, true)]
    {
        let report = run(&crossing(deep, [3.0, 2.0]), &profile());
        assert_eq!(report.counts.contains_key(&Rule::HeadCollision), found, "{deep}: {:#?}", report.findings);
        assert!(found || report.is_clean(), "{deep}: {:#?}", report.findings);
    }
    let report = run(&crossing(0.2, [3.0, 2.0]), &profile());
    let told = report.findings.iter().map(|finding| finding.measured).fold(0.0, f64::max);
    assert!((told - 0.2).abs() < 1e-6, "{told}");
    // Above the layer nothing is touched, however often it is crossed.
    assert!(run(&crossing(-0.2, [3.0, 2.0]), &profile()).is_clean());
}
