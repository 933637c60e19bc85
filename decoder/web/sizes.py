#!/usr/bin/env python3
"""The sizes in decoder/web/README.md: a table of the package, a sentence on the viewer and the gallery.

    sizes.py PACKAGE README           prints the sizes of a package (a folder that package.sh made), and fails where a number of the
                                      table is more than a tenth off
    sizes.py PACKAGE README --write   writes the table
    sizes.py --pages VIEWER GALLERY   prints the sentence, which tests/bench/regenerate.sh puts between its marks

SPDX-License-Identifier: MIT
"""
import glob
import gzip
import os
import re
import sys

BEGIN, END = "| | bytes | gzip |\n| --- | --- | --- |\n", "\n\n"
# By row, the files of the package that are loaded for it.
ROWS = (
    ("`openbtf.wasm`", ("openbtf.wasm",)),
    ("scripts of `openbtf`", ("index.js", "material.js", "module.js", "records.js")),
    ("more for `openbtf/webgl`", ("webgl*.js", "self_test_lists.js")),
    ("beside those, for `openbtf/three`", ("three.js", "three_options.js")),
    ("more for `openbtf/webgpu`", ("webgpu*.js", "self_test_lists.js")),
    ("beside those, for `openbtf/three-webgpu`", ("three_webgpu.js", "three_options.js")),
)
TOLERANCE = 0.1


def sizes(package):
    """[(row, bytes, bytes as gzip)]; files are compressed one by one, as a server sends them."""
    found = []
    for row, patterns in ROWS:
        names = sorted(name for pattern in patterns for name in glob.glob(os.path.join(package, pattern)))
        if not names:
            sys.exit(f"sizes.py: {package}: no file {', '.join(patterns)}")
        contents = []
        for name in names:
            with open(name, "rb") as file:
                contents.append(file.read())
        found.append((row, sum(map(len, contents)), sum(len(gzip.compress(content, 9, mtime=0)) for content in contents)))
    return found


def megabytes(number):
    """With two digits that count: what a commit changes shows rarely."""
    return f"{float(f'{number / 1e6:.2g}'):.{1 if number >= 0.995e6 else 2}f} MB"


def pages(viewer, gallery):
    """The sentence on the two pages."""
    said = []
    for path in (viewer, gallery):
        with open(path, "rb") as file:
            content = file.read()
        said.append((megabytes(len(content)), megabytes(len(gzip.compress(content, 9, mtime=0)))))
    return ("<!-- pages: written by tests/bench/regenerate.sh -->\n"
            f"`viewer.html` with one material of 0.5 MB is {said[0][0]} ({said[0][1]} by gzip), `gallery.html` with four {said[1][0]} ({said[1][1]}).\n"
            "<!-- /pages -->")


def main():
    if sys.argv[1:2] == ["--pages"]:
        print(pages(*sys.argv[2:]))
        return 0
    package, readme = sys.argv[1:3]
    with open(readme, encoding="utf-8") as file:
        text = file.read()
    start = text.index(BEGIN) + len(BEGIN)
    end = text.index(END, start)
    now = sizes(package)
    if sys.argv[3:] == ["--write"]:
        lines = "\n".join(f"| {row} | {size:,} | {packed:,} |" for row, size, packed in now)
        with open(readme + ".new", "w", encoding="utf-8") as file:
            file.write(text[:start] + lines + text[end:])
        os.replace(readme + ".new", readme)
        return 0
    stated = {}
    for line in text[start:end].split("\n"):
        row, *numbers = [cell.strip() for cell in line.strip("|").split("|")]
        stated[row] = [int(re.sub(",", "", number)) for number in numbers]
    wrong = 0
    for row, *numbers in now:
        print(f"{row}: {numbers[0]} bytes, {numbers[1]} as gzip")
        for number, of in zip(numbers, stated.get(row, [0, 0])):
            if abs(number - of) > TOLERANCE * number:
                print(f"{readme}: {row}: the table says {of}, the package has {number}; sizes.py --write writes it anew")
                wrong = 1
    return wrong


sys.exit(main())
