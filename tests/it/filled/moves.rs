//! The moves of a sliced file, mm, read by nobody's code but this.

/// A move as it stands in the file.
pub(crate) struct Step {
    pub(crate) from: [f64; 3],
    pub(crate) to: [f64; 3],
    /// Filament, mm.
    pub(crate) e: f64,
    /// Whether the slicer calls it a bridge.
    pub(crate) bridge: bool,
    /// The print it is of, where the file says so.
    pub(crate) print: usize,
}

/// All moves of a file with relative E, or with absolute E and G92.
pub(crate) fn steps(gcode: &str) -> Vec<Step> {
    let (mut at, mut last_e, mut relative, mut bridge, mut print) = ([0.0; 3], 0.0, false, false, 0);
    let mut found = Vec::new();
    for line in gcode.lines() {
        if let Some(kind) = line.strip_prefix(";TYPE:") {
            bridge = kind.starts_with("Bridge");
        }
        if let Some(number) = line.strip_prefix(";TRUNNION print=") {
            print = number.split(' ').next().unwrap().parse().unwrap();
        }
        let code = line.split(';').next().unwrap();
        let word =
            |letter: char| code.split_whitespace().skip(1).find_map(|w| w.strip_prefix(letter)?.parse::<f64>().ok());
        match code.split_whitespace().next().unwrap_or_default() {
            "M83" => relative = true,
            "M82" => relative = false,
            "G92" => last_e = word('E').unwrap_or(last_e),
            "G1" | "G0" => {
                let from = at;
                for (i, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
                    at[i] = word(letter).unwrap_or(at[i]);
                }
                let e = word('E').map_or(0.0, |e| if relative { e } else { e - last_e });
                last_e = word('E').unwrap_or(last_e);
                found.push(Step { from, to: at, e, bridge, print });
            }
            _ => {}
        }
    }
    found
}
