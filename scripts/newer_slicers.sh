#!/usr/bin/env bash
# Fetches the slicers of a newer Debian into a folder: PrusaSlicer and CuraEngine of RELEASE with all that they are linked to, and Cura's
# definitions of CuraEngine's settings. Nothing is installed; the programs run with the loader and the libraries beside them.
#
#   newer_slicers.sh FOLDER [RELEASE]      [default: trixie, which is Debian 13]
#
# FOLDER/bin has the commands, FOLDER/cura the definitions; it can be moved. Needs apt-get, dpkg-deb and 1.3 GB; some 350 MB are fetched. Exit code 1, with
# the reason, where it cannot be done; FOLDER is then as it was.
set -euo pipefail
folder=$(realpath -m "$1")
release=${2:-trixie}
keys=/usr/share/keyrings/debian-archive-keyring.gpg

[ "$(uname -m)" = x86_64 ] || { echo "only for x86_64"; exit 1; }
[ -r "$keys" ] || { echo "$keys is not there (package debian-archive-keyring)"; exit 1; }
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
chmod 755 "$place"

mkdir -p "$place"/{state/lists/partial,cache/archives/partial,files}
: >"$place/status"
echo "deb [signed-by=$keys] http://deb.debian.org/debian $release main" >"$place/sources.list"
# apt with lists of its own, to which nothing is installed as yet.
own_apt() {
    timeout -k 20 400 apt-get -q -y -o Dir::Etc::sourcelist="$place/sources.list" -o Dir::Etc::sourceparts=/dev/null \
        -o Dir::State="$place/state" -o Dir::State::status="$place/status" -o Dir::Cache="$place/cache" -o Acquire::Languages=none \
        -o APT::Install-Recommends=false -o Debug::NoLocking=1 -o APT::Sandbox::User=root "$@" </dev/null >"$place/log" 2>&1 ||
        { tail -n 3 "$place/log"; exit 1; }
}
own_apt update
own_apt --download-only install prusa-slicer cura-engine
(cd "$place" && own_apt download cura)

unpacked() { dpkg-deb --fsys-tarfile "$1" | tar -x -C "$2" "${@:3}"; }
for package in "$place"/cache/archives/*.deb; do
    unpacked "$package" "$place/files" --exclude='./usr/share/doc*' --exclude='./usr/share/man*' --exclude='./usr/share/locale*' \
        --exclude='./usr/share/icons*' --exclude='./dev*'
done
mkdir -p "$place/made/bin" "$place/made/cura" "$place/resources"
unpacked "$place"/cura_*.deb "$place/resources" --wildcards '*/resources/definitions/*' '*/resources/extruders/*'
cp -r "$place"/resources/usr/share/cura/resources/{definitions,extruders} "$place/made/cura/"
for program in prusa-slicer CuraEngine; do
    cat >"$place/made/bin/$program" <<'END'
#!/bin/sh
# The program of this name in ../files, with the loader and the libraries there.
files=$(dirname "$(realpath "$0")")/../files
lib=$files/usr/lib/x86_64-linux-gnu
exec "$files/usr/lib64/ld-linux-x86-64.so.2" --library-path "$lib:$lib/blas:$lib/lapack" "$files/usr/bin/${0##*/}" "$@"
END
    chmod +x "$place/made/bin/$program"
done
mv "$place/files" "$place/made/files"
for program in prusa-slicer CuraEngine; do
    "$place/made/bin/$program" --help >"$place/log" 2>&1 || true
    grep -qE 'PrusaSlicer-[0-9]|Cura_SteamEngine version' "$place/log" ||
        { tail -n 3 "$place/log"; echo "$program does not start"; exit 1; }
done
mkdir -p "$(dirname "$folder")"
rm -rf "$folder"
mv "$place/made" "$folder"
