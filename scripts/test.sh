#!/usr/bin/env bash
# Runs the tests of the repository. Needs Rust, git and python3; whatever else is missing is either installed (as root on Debian or Ubuntu) or left out
# aloud, never fatal. Long sweeps, other seeds and the slicers of Debian 13 in full are scripts/soak.sh's.
#
#   test.sh                        everything
#   test.sh --changed [REVISION]   only what the changes since REVISION (HEAD) can break, by room: for while one works, never in place of everything
#
#   TRUNNION_NO_APT=1              installs no packages
#
# Exit code 1 when a check failed; all of them run all the same, so that one run shows everything.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=scripts/steps.sh
source scripts/steps.sh
target="${CARGO_TARGET_DIR:-$PWD/target}"

if [ "${1:-}" = --changed ]; then
    if [ -d .venv/bin ]; then
        export PATH="$PWD/.venv/bin:$PATH"
    fi
    if [ -d .venv/cura/definitions ]; then
        export CURA_ENGINE_SEARCH_PATH="${CURA_ENGINE_SEARCH_PATH:-$PWD/.venv/cura/definitions:$PWD/.venv/cura/extruders}"
    fi
    have python3 || { echo "--changed needs python3"; exit 2; }
    filter=$(python3 scripts/changed.py "${2:-HEAD}")
    [ -n "$filter" ] || { echo "no room, test or document has changed since ${2:-HEAD}"; exit 0; }
    echo "$filter"
    step "tests of what has changed" cargo nextest run --locked --all-features --cargo-profile dev -E "$filter"
    ended
    exit
elif [ $# -gt 0 ]; then
    echo "usage: test.sh [--changed [REVISION]]"
    exit 2
fi

disk 8
say "programs"
programs

formats() {
    cargo fmt --check --package trunnion --package trunnion-python --package trunnion-benches && cargo fmt --check --manifest-path fuzz/Cargo.toml
}
if cargo fmt --version >/dev/null 2>&1; then
    step "format" formats
else
    skip "rustfmt is not installed"
fi

# No command builds the fuzzer, so nothing else says that the library has other dependencies now.
fuzzer_lock() {
    local said
    if said=$(cargo metadata --locked --manifest-path fuzz/Cargo.toml --format-version 1 2>&1 >/dev/null); then
        return
    fi
    printf '%s\n' "$said"
    if [[ $said == *"because --locked was passed"* ]]; then
        return 1
    fi
    echo "SKIPPED: fuzz/Cargo.lock was not checked: the packages of the fuzzer are not there"
}
step "lock file of the fuzzer" fuzzer_lock

# Lints and documentation are of the plain build, the tests of the one with all features: both are compiled.
lints_and_documentation() {
    local code=0
    if cargo clippy --version >/dev/null 2>&1; then
        cargo clippy --locked --lib --bins --examples --test it -- -D warnings || code=1
    else
        echo "SKIPPED: clippy is not installed"
    fi
    RUSTDOCFLAGS="${RUSTDOCFLAGS:-} -D warnings" cargo doc --locked --no-deps || code=1
    return $code
}
start_beside "lints and documentation" lints_and_documentation

if cargo deny --version >/dev/null 2>&1; then
    step "licences and sources of the dependencies" cargo deny --locked check licenses sources bans
else
    skip "licences and sources of the dependencies were not checked: cargo-deny is not there"
fi

# What is built, as a list for those who hand it on: as Cargo.lock has it, the same bytes twice, and a wrong hash is found in it.
bill_of_materials() {
    local bill=$work/trunnion.cdx.json
    python3 scripts/sbom.py -o "$bill" && python3 scripts/sbom.py --check "$bill" || return 1
    python3 scripts/sbom.py | cmp - "$bill" || return 1
    sed '0,/"content": "./s//"content": "x/' "$bill" >"$bill.other"
    ! python3 scripts/sbom.py --check "$bill.other" >/dev/null
}
if have python3 && cargo metadata --locked --format-version 1 >/dev/null 2>&1; then
    step "bill of materials" bill_of_materials
else
    skip "the bill of materials was not made: python3 or packages of other systems are not there"
fi

# The systems that the tests do not run on, where rustup has their libraries: the code is checked, nothing is linked.
other_systems() {
    local target code=0
    for target in $(rustup target list --installed 2>/dev/null | grep -E 'windows|darwin'); do
        echo "$target"
        cargo check --locked --target "$target" --lib --bins || code=1
    done
    return $code
}
if rustup target list --installed 2>/dev/null | grep -qE 'windows|darwin'; then
    step "Windows and macOS" other_systems
else
    skip "the code was not checked for Windows and macOS: rustup has no library of theirs (rustup target add x86_64-pc-windows-msvc)"
fi

# With the Python package, of which nothing is built here, what both need has the features of both: the wheel is built from the same library.
features=(--locked --all-features --package trunnion --package trunnion-python)
# Half of the tests' time is waiting for printers and servers: four times as many as processors keep these busy.
export NEXTEST_TEST_THREADS=${NEXTEST_TEST_THREADS:-$(($(nproc 2>/dev/null || echo 2) * 4))}
documents="$target/documents"
rm -rf "$documents"
export TRUNNION_DOCUMENTS=$documents
if cargo nextest --version >/dev/null 2>&1; then
    step "build" cargo nextest run "${features[@]}" --cargo-profile proof --no-run
    wait_beside
    step "tests" cargo nextest run "${features[@]}" --cargo-profile proof --no-fail-fast
    # What passing tests noted: nextest keeps their words to itself.
    [ ! -x .venv/bin/python ] || .venv/bin/python scripts/noted.py "$target/nextest/default/junit.xml" >>"$log" || true
else
    skip "cargo-nextest is not there: tests that need the machine for themselves run one after the other at the end"
    step "build" cargo test "${features[@]}" --profile proof --no-run
    wait_beside
    # --show-output: a test that leaves something out says so, and would be muted when it passes.
    step "tests" cargo test "${features[@]}" --profile proof --lib --bins --test it --no-fail-fast -- --show-output --skip link:: --skip publish::
    step "tests of the link" cargo test "${features[@]}" --profile proof --test it --no-fail-fast -- --show-output --test-threads 1 link:: publish::
fi
step "examples in the documentation" cargo test "${features[@]}" --profile proof --doc

# What slicers give, with the newer ones: one test of each kind. All of them are soak.sh's.
with_newer_slicers() {
    PATH="$PWD/$newer/bin:$PATH" CURA_ENGINE_SEARCH_PATH="$PWD/$newer/cura/definitions:$PWD/$newer/cura/extruders" \
        cargo nextest run "${features[@]}" --cargo-profile proof --no-fail-fast --profile newer
}
if [ -x $newer/bin/prusa-slicer ] && cargo nextest --version >/dev/null 2>&1; then
    step "tests with the slicers of Debian 13" with_newer_slicers
fi
if [ -x .venv/bin/python ] && .venv/bin/python -c 'import jsonschema' 2>/dev/null; then
    step "documents and their schemas" .venv/bin/python tests/harness/check_documents.py docs/schemas "$documents"
else
    skip "the documents that the tests printed were not checked against their schemas by a second program: jsonschema is not there"
fi

# The Python package as its users get it: a wheel in surroundings of its own, the example, its tests beside the command built above.
python_package() {
    local place="$target/python-package"
    rm -rf "$place" && mkdir -p "$place/example" || return 1
    CARGO_TARGET_DIR=$target maturin build --profile proof --strip --locked -m python/Cargo.toml -i .venv/bin/python --out "$place" || return 1
    python3 -m venv "$place/venv" || return 1
    timeout -k 20 300 "$place/venv/bin/python" -m pip install --quiet --disable-pip-version-check "$place"/*.whl </dev/null || return 1
    # What its tests look with; a test without its program says so.
    into_venv "$place/venv" mypy 300 "mypy (checks the types of the Python package)" mypy==1.18.2
    into_venv "$place/venv" pyright 300 "pyright (checks the types of the Python package)" "pyright[nodejs]==1.1.406"
    into_venv "$place/venv" nbclient 300 "nbclient and ipykernel (run a notebook)" nbclient==0.10.2 nbformat==5.10.4 ipykernel==6.30.1
    "$place/venv/bin/python" python/examples/first_print.py "$place/example" || return 1
    TRUNNION="$target/proof/trunnion" timeout -k 20 1800 "$place/venv/bin/python" -m unittest discover -s python/tests || return 1
}
if [ -x .venv/bin/python ] && .venv/bin/python -c 'import maturin' 2>/dev/null; then
    step "Python package" python_package
else
    skip "the Python package was not built: maturin is not there"
fi

say "summary"
real_programs
counted
left_out
cat <<'TEXT'
left to scripts/soak.sh: longer and other random sweeps (fuzz targets, solids, plans, slices), fuzzing, every test of what slicers give with those of Debian 13,
  Ray, builds in two folders, a wheel for older systems, the static binary, lints of the unit tests and of the Python package
TEXT
ended
