# Sourced by encoder/demo.sh and tests/run.sh: installs packages that are missing, and builds.
# Expects $root, the source folder. Exits 2 with a message when something is missing and cannot be installed.
#
# SPDX-License-Identifier: MIT

# shown NAME: draws progress from lines "STAGE PERCENT" or "PERCENT": a bar on a terminal, a line each tenth in a log.
shown() {
    local name=$1 words stage percent at tenth=-1 bar='########################' dots='........................'
    while read -r -a words; do
        percent=${words[-1]%%.*}
        [ ${#words[@]} -gt 1 ] && [ "${words[0]}" != "$name" ] && name=${words[0]} tenth=-1
        if [ -t 1 ]; then
            at=$((percent * ${#bar} / 100))
            printf '\r\033[K%-17s [%s%s] %3d%%\r' "$name" "${bar:0:at}" "${dots:at}" "$percent"
        elif [ $((percent / 10)) -gt $tenth ]; then
            tenth=$((percent / 10))
            echo "$name: $percent%"
        fi
    done
    if [ -t 1 ]; then printf '\r\033[K'; fi
}

# apt reports its stages as "dlstatus:3:41.2:text", "pmstatus:package:7.5:text".
apt_stages() {
    local kind name percent
    while IFS=: read -r kind name percent _; do
        case $kind in
        dlstatus) echo "downloading $percent" ;;
        pmstatus) echo "installing $percent" ;;
        esac
    done
}

# install_packages PURPOSE...: the packages of .ci/packages-PURPOSE.txt.
install_packages() {
    local purpose package missing=() log=$root/.packages.log
    for purpose in "$@"; do
        for package in $(sed -e 's/#.*//' "$root/.ci/packages-$purpose.txt"); do
            # a nodejs that is not Debian's brings npm, and conflicts with Debian's
            [ "$package" = npm ] && command -v npm >/dev/null && continue
            if [ "$(dpkg-query -W -f '${db:Status-Abbrev}' "$package" 2>/dev/null)" != "ii " ]; then
                missing+=("$package")
            fi
        done
    done
    [ ${#missing[@]} -eq 0 ] && return 0
    if [ "$(id -u)" -ne 0 ] || ! command -v apt-get >/dev/null; then
        echo "These Debian packages are missing; install them as root: apt-get install --no-install-recommends ${missing[*]}" >&2
        exit 2
    fi
    echo "Installing ${#missing[@]} packages and what they need: ${missing[*]}"
    export DEBIAN_FRONTEND=noninteractive
    if ! { apt-get update -q >"$log" 2>&1 && set -o pipefail &&
        apt-get install -y -q --no-install-recommends -o APT::Status-Fd=3 "${missing[@]}" 3>&1 >"$log" 2>&1 </dev/null |
        apt_stages | shown packages; }; then
        tail -20 "$log" >&2
        echo "apt-get could not install: ${missing[*]}" >&2
        exit 2
    fi
    set +o pipefail
    rm -f "$log"
}

# The percentages of ninja's lines "[12/493] Compiling ..."; the lines go to the log.
ninja_percents() {
    local line
    while IFS= read -r line; do
        printf '%s\n' "$line" >&3
        [[ $line =~ ^\[([0-9]+)/([0-9]+)\] ]] && echo $((100 * BASH_REMATCH[1] / BASH_REMATCH[2]))
    done 3>"$1"
}

# build FOLDER [meson option...] [-- target...]: configures, again with other options, and compiles.
build() {
    local folder=$1 command=setup options=()
    shift
    while [ $# -gt 0 ] && [ "$1" != -- ]; do
        options+=("$1")
        shift
    done
    [ $# -gt 0 ] && shift
    if [ -f "$folder/build.ninja" ]; then
        command=configure
    else
        options=("$root" "${options[@]}")
    fi
    if [ ${#options[@]} -gt 0 ]; then
        meson $command "$folder" "${options[@]}" >"$folder.setup.log" 2>&1 || {
            cat "$folder.setup.log" >&2
            exit 2
        }
        rm -f "$folder.setup.log"
    fi
    if [ -t 1 ]; then # on a terminal ninja shows its own progress
        ninja -C "$folder" "$@" || exit 2
        return
    fi
    ninja -C "$folder" "$@" 2>&1 | ninja_percents "$folder/ninja.log" | shown "building in $(basename "$folder")"
    if [ "${PIPESTATUS[0]}" != 0 ]; then
        grep -v '^\[[0-9]*/[0-9]*\]' "$folder/ninja.log" | tail -60 >&2
        exit 2
    fi
}
