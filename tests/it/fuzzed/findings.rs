//! What was found once, as small as it could be made: by the fuzzer, by these tests, or in looking for the causes of both. Each is mended,
//! and is given to its target at the beginning of every turn.

/// Target, the bytes that choose, and the rest.
const FOUND: &[(&str, &[u8], &[u8])] = &[
    // An F that is no number as an f32, and one whose times have no sum.
    ("gcode", &[0], b"G1X1F999999999999999999999999999999999999999\n"),
    ("gcode", &[0], b"G90\nG1X0Y0Z0F.00000000000000000000000000000000000000000001\nG1X9\n"),
    ("gcode", &[0], b"G92E999999999999999999999999999999999999999\nG1X1E0\n"),
    // Gigabytes of chords.
    ("gcode", &[6], b"G1X0Y0Z0F600\nG2X0Y0I5P4294967295\n"),
    // Durations that overflow.
    ("gcode", &[0], b"G4S18446744073709550000\nG4S18446744073709550000\n"),
    ("reply", &[2, 31], b"M109 S99999999999999999999999999\nM105\n"),
    // Something is kept for each number that may be under way.
    ("journal", &[15, 0], b"trunnion-journal 1\nrun 3 0\nrun 429496729570 60\n"),
    ("journal", &[0, 0], b"trunnion-journal 1\nrun 3 0\nack -9223372036854775808 60\n"),
    ("journal", &[0, 0], b"trunnion-journal 1\nrun 3 4294967295\nack 9 60\n"),
    // A pause behind the program's end.
    ("journal", &[15, 70], b"trunnion-journal 1\nrun 3 0\nack 70 60\naway\npaused 482840\n"),
    // Models of no parts, and of parts of no volume.
    ("mesh", &[2], b"OFF\n3 2 0\n1 1 1\n1 1 1\n1 1 1\n3 0 1 2\n3 0 2 1\n"),
    ("mesh", &[17], b"OFF\n6 2 0\n0 0 0\n9 0 0\n9 0 1e-7\n50 0 0\n59 0 0\n59 0 1e-7\n3 0 1 2\n3 3 4 5\n"),
    ("mesh", &[2], b"OFF\n4 4 0\n0 0 0\n1e-200 0 0\n0 1e-200 0\n0 0 1e-200\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"),
    ("mesh", &[17], b"OFF\n4 2 0\n1e7 0 0\n9999999.99999999 0 0\n1e7 1e-9 0\n1e7 0 1e-9\n3 0 1 2\n3 0 2 3\n"),
    // A name that no 3MF can hold, which is written into one.
    ("mesh", &[11], b"o a\x01b\nv 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"),
    // Thousands of objects out of a few lines.
    ("mesh", &[192], DOUBLED),
];

/// Components that double level by level.
const DOUBLED: &[u8] = b"<model><resources><object id=\"1\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"9\" y=\"0\" z=\"0\"/>\
    <vertex x=\"0\" y=\"9\" z=\"0\"/><vertex x=\"0\" y=\"0\" z=\"9\"/></vertices><triangles><triangle v1=\"0\" v2=\"2\" v3=\"1\"/>\
    <triangle v1=\"0\" v2=\"1\" v3=\"3\"/><triangle v1=\"0\" v2=\"3\" v3=\"2\"/><triangle v1=\"1\" v2=\"2\" v3=\"3\"/></triangles></mesh></object>\
    <object id=\"2\"><components><component objectid=\"1\"/><component objectid=\"1\"/></components></object>\
    <object id=\"3\"><components><component objectid=\"2\"/><component objectid=\"2\"/></components></object>\
    <object id=\"4\"><components><component objectid=\"3\"/><component objectid=\"3\"/></components></object>\
    <object id=\"5\"><components><component objectid=\"4\"/><component objectid=\"4\"/></components></object>\
    <object id=\"6\"><components><component objectid=\"5\"/><component objectid=\"5\"/></components></object>\
    <object id=\"7\"><components><component objectid=\"6\"/><component objectid=\"6\"/></components></object>\
    <object id=\"8\"><components><component objectid=\"7\"/><component objectid=\"7\"/></components></object>\
    <object id=\"9\"><components><component objectid=\"8\"/><component objectid=\"8\"/></components></object>\
    <object id=\"10\"><components><component objectid=\"9\"/><component objectid=\"9\"/></components></object>\
    <object id=\"11\"><components><component objectid=\"10\"/><component objectid=\"10\"/></components></object>\
    <object id=\"12\"><components><component objectid=\"11\"/><component objectid=\"11\"/></components></object>\
    </resources><build><item objectid=\"12\"/></build></model>";

/// The inputs of a target.
pub(super) fn of(target: &str) -> impl Iterator<Item = Vec<u8>> {
    FOUND.iter().filter(move |(of, ..)| *of == target).map(|(_, choice, rest)| [*choice, *rest].concat())
}
