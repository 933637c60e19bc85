# shellcheck shell=bash disable=SC2154
# For the scripts beside this one to read (".") once they have set root, the folder of the sources.
#
# SPDX-License-Identifier: MIT
commit() { # of the sources; + where they were changed since, but for the documents that the scripts write
    local at
    local -a code=('*.c' '*.cc' '*.h' '*.glsl' '*.sh' '*.py' '*.js' '*.mjs' '*.css' '*.html')
    at=$(git -C "$root" rev-parse --short HEAD 2>/dev/null) || at=unknown
    git -C "$root" diff --quiet HEAD -- "${code[@]}" 2>/dev/null || at=$at+$(git -C "$root" diff HEAD -- "${code[@]}" | cksum | cut -d' ' -f1)
    echo "$at"
}
