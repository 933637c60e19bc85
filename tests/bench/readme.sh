#!/bin/bash
# Measures what the README shows of encoding and decoding, and writes it there: two plots in tests/data/readme/
# and what stands between the two `bench` marks of README.md.
#
#   tests/bench/readme.sh [BUILD [btf-bench option...]]    default: build --quick
#   tests/bench/readme.sh --from DIR                       of a finished run
#   tests/bench/readme.sh --plan DIR                       the tables of scenes between the two `plan` marks, of a
#                                                          finished run of btf-bench --only plan --out DIR
#
# SPDX-License-Identifier: MIT
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
marks=$root/tests/bench/marks.py
if [ "${1:-}" = --plan ]; then
    python3 - "${2:?expected a folder after --plan}" <<'EOF' | "$marks" "$root/README.md" plan
import glob, os, re, sys
out = sys.argv[1]
with open(f"{out}/summary.md") as file:
    summary = file.read()
def field(key):
    return re.search(r"\| " + key + r" \| (.*) \|", summary).group(1)
text = f"""<!-- plan: written by tests/bench/readme.sh --plan -->
Machine: {field("processor")}; load {field("load before the run")} before the run.
"""
for path in sorted(glob.glob(f"{out}/readme-plan-*.md")):
    with open(path) as file:
        table = file.read().strip()
    if re.search(r"\| *\||\b0 of 0\b", table):
        sys.exit(f"{path}: a blank cell")
    name = os.path.basename(path)[len("readme-plan-"):-len(".md")]
    text += f"\n**{name}**. {table}\n"
print(text + "<!-- /plan -->")
EOF
    exit
fi
if [ "${1:-}" = --from ]; then
    out=${2:?expected a folder after --from}
else
    build=${1:-$root/build}
    shift || true
    [ $# -gt 0 ] || set -- --quick
    out=$build/bench-readme
    "$build/tests/bench/btf-bench" --only machine,encode,decode --out "$out" "$@"
fi
name=$(basename "$out"/readme-encode-*.md .md)
name=${name#readme-encode-}
for plot in encode decode; do
    cp "$out/readme-$plot-$name.png" "$root/tests/data/readme/$plot.png"
done
python3 - "$out" "$name" <<'EOF' | "$marks" "$root/README.md" bench
import re, sys
out, name = sys.argv[1:]
def read(path):
    with open(path) as file:
        return file.read()
def part(kind):
    return read(f"{out}/{kind}-{name}.md").strip()
summary = read(f"{out}/summary.md")
def field(key):
    return re.search(r"\| " + key + r" \| (.*) \|", summary).group(1)
data = re.search(r"data: (.*)\.\n", summary[summary.index("## encode"):]).group(1)
held = re.search(r"Left out of encoding: (.*)\.\n", summary)
text = f"""<!-- bench: written by tests/bench/readme.sh -->
Data: {data}. Machine: {field("processor")}; {field("threads")} threads; load {field("load before the run")} before
the run. Repeats: {field("repeats")}. PSNR in dB, linear / sRGB-coded{"; held out: " + held.group(1) if held else ""}.

![Encoding: time against accuracy](tests/data/readme/encode.png)

{part("readme-encode")}

![Decoding: time against accuracy](tests/data/readme/decode.png)

{part("readme-decode")}

### What to choose

{part("guide-encode")}

{part("guide-decode")}
<!-- /bench -->"""
print(text)
EOF
