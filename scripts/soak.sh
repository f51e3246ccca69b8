#!/usr/bin/env bash
# What scripts/test.sh leaves out because it takes hours: the whole of each sweep of which the suite has a part, from seeds that are new each time, every
# test of what slicers give with those of Debian 13, fuzzing, Ray, builds in two folders, a wheel for older systems, the static
# binary and the remaining lints. Goes on after a finding.
#
#   soak.sh [SEED]        SEED: the first of the random seeds (else the seconds since 1970); the same one repeats a run
#
#   TRUNNION_NO_APT=1     installs no packages
#   TRUNNION_FUZZ_S=N     seconds of fuzzing for each target (600), where cargo-fuzz and a nightly toolchain are there
#
# Exit code 1 when something was found.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=scripts/steps.sh
source scripts/steps.sh
target="${CARGO_TARGET_DIR:-$PWD/target}"
seed=${1:-$(date +%s)}

disk 12
say "programs"
programs
cargo nextest --version >/dev/null 2>&1 || { echo "soak.sh needs cargo-nextest"; exit 2; }
echo "the seed is $seed: bash scripts/soak.sh $seed"

nextest_of() {
    cargo nextest run --locked --all-features --cargo-profile proof --no-fail-fast "$@"
}

remaining_lints() {
    cargo clippy --locked --workspace --all-targets --all-features -- -D warnings
}
if cargo clippy --version >/dev/null 2>&1; then
    step "lints of everything" remaining_lints
else
    skip "clippy is not installed"
fi

# Slowest first, so that two processors end together; each is told aloud with its seeds.
export TRUNNION_SOAK=$seed
step "sweeps with other seeds" nextest_of --run-ignored all --profile soak
unset TRUNNION_SOAK

with_newer_slicers() {
    PATH="$PWD/$newer/bin:$PATH" CURA_ENGINE_SEARCH_PATH="$PWD/$newer/cura/definitions:$PWD/$newer/cura/extruders" nextest_of --profile newer-whole
}
if [ -x $newer/bin/prusa-slicer ]; then
    step "every test of what slicers give, with those of Debian 13" with_newer_slicers
fi

# The tables and figures of the five documents, whole; with their meshes where those are given.
five_documents() {
    local meshes=()
    [ -z "${TRUNNION_MESHES:-}" ] || meshes=(--meshes "$TRUNNION_MESHES")
    cargo run --locked --all-features --profile proof --example reproduce -- --out "$target/reproduce" "${meshes[@]}"
}
step "the five documents" five_documents

ray() {
    local place="$target/python-soak"
    rm -rf "$place" && mkdir -p "$place" || return 1
    CARGO_TARGET_DIR=$target maturin build --profile proof --strip --locked -m python/Cargo.toml -i .venv/bin/python --out "$place" || return 1
    python3 -m venv "$place/venv" || return 1
    timeout -k 20 300 "$place/venv/bin/python" -m pip install --quiet --disable-pip-version-check "$place"/*.whl </dev/null || return 1
    timeout -k 20 600 "$place/venv/bin/python" -m pip install --quiet --disable-pip-version-check ray==2.60.0 </dev/null ||
        echo "SKIPPED: Ray could not be installed"
    timeout -k 20 900 "$place/venv/bin/python" python/tests/check_ray.py "$place/ray" || return 1
}
if [ -x .venv/bin/python ] && .venv/bin/python -c 'import maturin' 2>/dev/null; then
    step "Ray" ray
else
    skip "Ray was not tried: maturin is not there"
fi

# A binary that needs nothing of the system, where Rust's library for musl and a compiler for it are there.
static_binary() {
    local musl=x86_64-unknown-linux-musl
    cargo build --locked --all-features --bin trunnion --target "$musl" || return 1
    "$target/$musl/debug/trunnion" --version || return 1
    { ldd "$target/$musl/debug/trunnion" 2>&1 || true; } | grep -E 'statically linked|not a dynamic executable'
}
if [ ! -d "$(rustc --print sysroot)/lib/rustlib/x86_64-unknown-linux-musl" ]; then
    skip "the static binary was not built: Rust's library for it is not there (rustup target add x86_64-unknown-linux-musl)"
elif ! have musl-gcc; then
    skip "the static binary was not built: musl-gcc is not there (package musl-tools)"
else
    step "static binary" static_binary
fi

# One commit, built in two folders of different names: the same bytes.
same_bytes() {
    local place="$target/same-bytes" folder code=0
    rm -rf "$place"
    for folder in one "another folder"; do
        git clone -q . "$place/$folder" || return 1
        (cd "$place/$folder" && CARGO_TARGET_DIR="$place/$folder/target" cargo build --release --locked --bin trunnion) || return 1
    done
    cmp "$place/one/target/release/trunnion" "$place/another folder/target/release/trunnion" || code=1
    rm -rf "$place"
    return $code
}
step "the same bytes in two folders" same_bytes

# A wheel that runs on systems older than this one, linked by zig.
older_systems() {
    local place="$target/python-older"
    rm -rf "$place"
    CARGO_TARGET_DIR=$target maturin build --release --locked --zig --compatibility manylinux2014 -m python/Cargo.toml -i .venv/bin/python --out "$place" || return 1
    python3 -m venv "$place/venv" && timeout -k 20 300 "$place/venv/bin/python" -m pip install --quiet --disable-pip-version-check "$place"/*.whl </dev/null || return 1
    "$place/venv/bin/python" -c 'import sys, trunnion; trunnion.prepare("fixtures/y-tree.stl", "generic-ac", slicer="builtin", output=sys.argv[1])' "$place/y-tree.gcode" || return 1
    cargo run --locked --all-features --profile proof -- prepare fixtures/y-tree.stl -m generic-ac --slicer builtin -q -o "$place/own.gcode" || return 1
    cmp "$place/y-tree.gcode" "$place/own.gcode"
}
from_registry ziglang 600 "zig (a wheel for older systems)" ziglang==0.17.1
if [ -x .venv/bin/python ] && .venv/bin/python -c 'import maturin, ziglang' 2>/dev/null; then
    step "a wheel for older systems" older_systems
else
    skip "no wheel for older systems was built: maturin or zig is not there"
fi

# Guided by what the code does with the bytes: docs/explanation/fuzzing.md.
fuzzing() {
    local one code=0
    TRUNNION_CORPUS=fuzz/corpus nextest_of fuzzed::every_target_has_seeds || return 1
    for one in config gcode journal mesh plan profile program reply rewrite; do
        cargo +nightly fuzz run -s none "$one" -- -max_total_time="${TRUNNION_FUZZ_S:-600}" -seed="$((seed % 2147483647))" \
            -rss_limit_mb=2048 -timeout=10 -max_len=65536 -dict=tests/it/fuzzed/words.dict || code=1
        # What reaches the same with fewer bytes is kept for the next time.
        cargo +nightly fuzz cmin -s none "$one" || code=1
    done
    return $code
}
if cargo +nightly fuzz --version >/dev/null 2>&1; then
    step "fuzzing" fuzzing
else
    skip "nothing was fuzzed: cargo-fuzz or a nightly toolchain is not there (docs/explanation/fuzzing.md)"
fi

say "summary"
real_programs
counted
left_out
echo "the seed was $seed"
ended
