# Sourced by the stability scripts: a scratch folder, the tools on PATH, and the lines that table.py describes.
#
# SPDX-License-Identifier: MIT
. "$BTF_SOURCE_ROOT/tests/tools/common.sh" || exit 99
broken=0 asked=0

# Whether the tools are built with AddressSanitizer: slower, and with all addresses taken.
sanitized() { nm -D "$(command -v btf-encode)" 2>/dev/null | grep -q __asan; }

title() { echo "TITLE | $1"; }

# verdict INPUT EXPECTED SEEN: the case passes when `complain` was not called since the last verdict.
verdict() {
    local result=pass
    if [ "$broken" -gt 0 ]; then
        result=FAIL
        failures=$((failures + 1))
    fi
    echo "CASE | $1 | $2 | $3 | $result"
    broken=0 asked=$((asked + 1))
}

skipped() { # INPUT EXPECTED REASON
    echo "skipped: $1: $3"
    echo "CASE | $1 | $2 | skipped: $3 | skip"
}

complain() {
    echo "complaint: $*"
    broken=$((broken + 1))
}

# must COMMAND...: complains unless it succeeds.
must() { "$@" >that 2>&1 || complain "$* failed: $(head -c 300 that)"; }

# Runs a command; its exit code goes to $code, what it prints to err.
try() {
    "$@" >out 2>err </dev/null
    code=$?
}

# one_of CODE...: complains unless $code is among them.
one_of() {
    local allowed
    for allowed in "$@"; do [ "$code" = "$allowed" ] && return; done
    complain "exit code $code, expected one of $*: $(head -c 300 err)"
}

# The message in err, on one line, without the scratch folder's name.
message() { head -c 300 err | sed "s#$work/##g" | tr '|\n' '/ ' | head -c 110; }

temporaries() { find "$1" -name '.*.tmp' | wc -l; }
