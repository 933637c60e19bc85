# Sourced by encoder/demo.sh and tests/run.sh: installs the packages of .ci/packages.txt that are missing.
# Expects $root, the source folder. Exits 2 with a message when something is missing and cannot be installed.
#
# SPDX-License-Identifier: MIT

install_packages() {
    local wanted missing=()
    wanted=$(sed -e 's/#.*//' "$root/.ci/packages.txt")
    for package in $wanted; do
        if [ "$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null)" != "ii " ]; then
            missing+=("$package")
        fi
    done
    [ ${#missing[@]} -eq 0 ] && return 0
    if [ "$(id -u)" -ne 0 ]; then
        echo "These Debian packages are missing; install them as root: apt-get install --no-install-recommends ${missing[*]}" >&2
        exit 2
    fi
    echo "Installing ${#missing[@]} packages: ${missing[*]}"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -q >/dev/null && apt-get install -y -q --no-install-recommends "${missing[@]}" >"$root/.packages.log" 2>&1 || {
        tail -20 "$root/.packages.log" >&2
        echo "apt-get could not install the packages of .ci/packages.txt" >&2
        exit 2
    }
    rm -f "$root/.packages.log"
}

# build FOLDER [meson option...]: configures, again with other options, and compiles.
build() {
    local folder=$1
    shift
    local command=setup
    [ -f "$folder/build.ninja" ] && command=configure
    if [ $command = setup ]; then
        set -- "$root" "$@"
    fi
    if [ $# -gt 0 ]; then
        meson $command "$folder" "$@" >"$folder.setup.log" 2>&1 || {
            cat "$folder.setup.log" >&2
            exit 2
        }
        rm -f "$folder.setup.log"
    fi
    ninja -C "$folder" >"$folder/ninja.log" 2>&1 || {
        grep -v '^\[[0-9]*/[0-9]*\]' "$folder/ninja.log" | tail -60 >&2
        exit 2
    }
}
