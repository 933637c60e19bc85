#!/bin/bash
# Measures what tests/bench/README.md shows of encoding and decoding, and writes it there: plots in tests/data/readme/ and
# what stands between marks of that page.
#
#   tests/bench/readme.sh [BUILD [btf-bench option...]]    default: build --quick
#   tests/bench/readme.sh --from DIR                       of a finished run
#   tests/bench/readme.sh --between DIR [DIR...]           accuracy between the samples, and over bytes, between the two
#                                                          `between` marks, of finished runs of btf-bench --only
#                                                          between, one of them with storage; no times, so that a
#                                                          busy machine may do
#   tests/bench/readme.sh --plan DIR                       the tables of scenes between the two `plan` marks, of a
#                                                          finished run of btf-bench --only plan --out DIR
#   tests/bench/readme.sh --growth DIR                     what stands between the marks `growth` of encoder/README.md,
#                                                          of a finished run of btf-bench --only growth --out DIR
#
# SPDX-License-Identifier: MIT
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
marks=$root/tests/bench/marks.py page=$root/tests/bench/README.md
export PYTHONPATH=$root/tests/bench PYTHONDONTWRITEBYTECODE=1 # for tables.py
if [ "${1:-}" = --plan ]; then
    python3 - "${2:?expected a folder after --plan}" <<'EOF' | "$marks" "$page" plan
import glob, os, re, sys
from tables import field, summary_of
out = sys.argv[1]
summary = summary_of(out)
text = f"""<!-- plan: written by tests/bench/readme.sh --plan -->
Machine: {field(summary, "processor")}; load {field(summary, "load before the run")} before the run.
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
if [ "${1:-}" = --growth ]; then
    python3 - "${2:?expected a folder after --growth}" <<'EOF' | "$marks" "$root/encoder/README.md" growth
import re, sys
from tables import field, summary_of
summary = summary_of(sys.argv[1])
exponents = re.findall(r"^\| (joint \w+|paper) \| (texels|views and as many lights) \| ([\d.]+) \| ([\d.]+) \|$",
                       summary, re.M)
by = {(method, over): f"{time} / {memory}" for method, over, time, memory in exponents}
seconds = {}
for method, texels, time in re.findall(r"^\| (joint \w+|paper); (\d+x\d+) texels; directions ubo \| ([\d.]+) \|", summary, re.M):
    seconds.setdefault((method, texels), float(time))  # the sweep over directions repeats 32x32
methods = [method for method, over in by if over == "texels"]
assert methods and len(by) == 2 * len(methods), "no table of exponents"
label = {method: method.replace("joint ", "joint, `") + ("`" if method.startswith("joint") else "") for method in methods}
rows = "".join(f"| {label[m]} | {by[m, 'texels']} | {by[m, 'views and as many lights']} | {seconds[m, '16x16']:.1f}, "
               f"{seconds[m, '32x32']:.1f}, {seconds[m, '64x64']:.1f} |\n" for m in methods)
print(f"""<!-- growth: written by tests/bench/readme.sh --growth -->
`btf-sample` bricks; {field(summary, "processor")}; load {field(summary, "load before the run")} before the run; one encode each.

| fitted exponents, time / memory | over texels | over views and as many lights | core s of 16x16, 32x32, 64x64 texels |
| --- | --- | --- | --- |
{rows}<!-- /growth -->""")
EOF
    exit
fi
if [ "${1:-}" = --between ]; then
    shift
    : "${1:?expected a folder after --between}"
    for dir in "$@"; do
        for plot in "$dir"/readme-storage-*.png; do
            [ ! -e "$plot" ] || cp "$plot" "$root/tests/data/readme/storage.png"
        done
    done
    python3 - "$@" <<'EOF' | "$marks" "$page" between
import glob, os, re, sys, textwrap
shown = ("joint ", "paper", "low-bit split PCA", "uncompressed")
sources, rows, stored = {}, [], ""
for out in sys.argv[1:]:
    with open(f"{out}/summary.md") as file:
        summary = file.read()
    for name, source in re.findall(r"Truth between the samples of (.*): (.*)\.\n", summary):
        path = f"{out}/readme-between-{name}.md"
        if os.path.exists(path):
            data = re.search(r"## between: " + name + r"\n\n.*; data: (.*)\.\n", summary).group(1)
            label, size = data.split(", ", 1)
            sources.setdefault(f"{size} ({source})", []).append(label)
            with open(path) as file:
                rows += [row for row in file if row.split(" | ")[1].startswith(shown)]
    plotted = re.search(r"## storage: .*\n\n.*; data: (.*)\.\n", summary)
    if plotted and glob.glob(f"{out}/readme-storage-*.png"):
        stored = plotted.group(1)
assert rows and stored, "no table, or no plot"
listed = "; ".join(", ".join(labels) + ": " + what for what, labels in sources.items())
words = textwrap.fill(f"""PSNR, linear / sRGB-coded dB. {listed}. The estimate leaves out view and light of 256 pairs of samples
and predicts them from the others. Principal components (PCA) and the uncompressed images are blended barycentrically, as
the decoder does; splines are thin plates through all directions.""", 119, break_on_hyphens=False)
print(f"""<!-- between: written by tests/bench/readme.sh --between -->
{words}

| data | codec | between the samples | at the samples | estimate | GPU MB |
| --- | --- | --- | --- | --- | --- |
{"".join(rows)}
![Bytes against accuracy between the samples and at them: {stored}](../data/readme/storage.png)
<!-- /between -->""")
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
python3 - "$out" "$name" <<'EOF' | "$marks" "$page" bench
import re, sys
from tables import field, summary_of
out, name = sys.argv[1:]
def read(path):
    with open(path) as file:
        return file.read()
def part(kind):
    return read(f"{out}/{kind}-{name}.md").strip()
summary = summary_of(out)
data = re.search(r"data: (.*)\.\n", summary[summary.index("## encode"):]).group(1)
truth = re.search(r"Truth between the samples of .*: (.*)\.\n", summary)
held = re.search(r"Left out of encoding: (.*)\.\n", summary)
text = f"""<!-- bench: written by tests/bench/readme.sh -->
Data: {data}. Machine: {field(summary, "processor")}; {field(summary, "threads")} threads; load {field(summary, "load before the run")} before
the run. Repeats: {field(summary, "repeats")}. PSNR in dB, linear / sRGB-coded{"; between: " + truth.group(1) if truth else ""}{
"; held out: " + held.group(1) if held else ""}.

![Encoding: time against accuracy](../data/readme/encode.png)

{part("readme-encode")}

![Decoding: time against accuracy](../data/readme/decode.png)

{part("readme-decode")}

### What to choose

{part("guide-encode")}

{part("guide-decode")}
<!-- /bench -->"""
print(text)
EOF
