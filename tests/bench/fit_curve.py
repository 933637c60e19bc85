#!/usr/bin/env python3
"""Draws what fits of node values gain and cost: tests/data/readme/fit.png, for encoder/nodes/FIT.md.

    tests/bench/fit_curve.py REPORT.json [REPORT.json...]

The reports are those of btf-encode --report with --fit between. Each gives a line, named by its input, whose name may end with a
commit (as regenerate.sh has it), with a point
for each candidate: the expected gain in dB between the samples (the mean of linear and sRGB-coded) over the expected loss in
dB at them (sRGB-coded). A ring marks the candidate that was chosen.

SPDX-License-Identifier: MIT
"""
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


def curve(path):
    with open(path) as file:
        report = json.load(file)
    fit = report["fit"]
    if fit is None or len(fit["candidates"]) < 2:
        sys.exit(f"{path}: no fit of nodes was judged")
    plain, points = fit["candidates"][0], []
    for c in fit["candidates"]:
        lost = plain["coded_at_srgb"] - c["coded_at_srgb"]
        gained = sum(c[f"coded_between_{k}"] - plain[f"coded_between_{k}"] for k in ("linear", "srgb")) / 2
        points.append((lost, gained, c["candidate"] == fit["chosen"]))
    name = os.path.basename(report["input"].rstrip("/")).removesuffix(".zip").replace("_", " ")
    name = re.sub(r"-[0-9a-f]{7,}(\+\d+)?$", "", name)
    return name, points


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    curves = [curve(path) for path in sys.argv[1:]]
    lines, script = [], []
    for i, (name, points) in enumerate(curves):
        script.append(f"$c{i} << E\n" + "\n".join(f"{x} {y}" for x, y, _ in points) + "\nE\n")
        script.append(f"$t{i} << E\n" + "\n".join(f"{x} {y}" for x, y, taken in points if taken) + "\nE\n")
        lines.append(f"$c{i} with linespoints lc {i + 1} pt 7 ps 0.6 title '{name}'")
        lines.append(f"$t{i} with points lc {i + 1} pt 6 ps 2.2 lw 2 notitle")
    out = os.path.join(ROOT, "tests", "data", "readme", "fit.png")
    head = (f"set terminal pngcairo size 800,480 font 'sans,11' background 'white'\nset output '{out}'\nset grid\nset key left top\n"
            "set xrange [0:4]\nset yrange [0:4]\nset xlabel 'dB lost at the samples'\n"
            "set ylabel 'dB gained between them, expected'\n")
    subprocess.run(["gnuplot"], input="".join(script) + head + "plot " + ", ".join(lines) + "\n", text=True, check=True)


main()
