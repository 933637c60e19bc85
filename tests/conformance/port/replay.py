#!/usr/bin/env python3
"""Replays the test vectors of `btf-conform --vectors DIR` with a decoder of its own.

    replay.py DIR [--pixels N]

Written from decoder/FORMAT.md in plain Python, without the library, the reference or OpenEXR: what the vectors and
the format's text say has to be enough to port the decoder. Exits 0 when every bit agrees, 7 when one differs.

SPDX-License-Identifier: MIT
"""
import argparse
import json
import os
import sys

import replay_sampling
from replay_arithmetic import random_numbers, to_bits
from replay_exr import read_exr
from replay_material import Material


def read_tables(directory, vector, material, images):
    """The tables of a vector with light sampling; adds its pictures to the others."""
    for plane in ("drawn", "density"):
        images[plane] = next(iter(read_exr(os.path.join(directory, vector[plane])).values()))
    picture = next(iter(read_exr(os.path.join(directory, vector["tables"])).values()))
    words = [picture.channels[c][y][x] for y in range(picture.height) for x in range(picture.width) for c in "RGB"]
    return replay_sampling.Tables(words, vector["triangles"], material.n_views, material.n_lights)


def sampled(material, tables, pixel, random):
    """The direction that two random numbers draw, its density, and that of the pixel's light."""
    drawn, density = [0.0, 0.0, 1.0], 0.0
    if replay_sampling.is_above(pixel["view"]):
        drawn = replay_sampling.draw_light(material, tables, pixel["view"], random[0], random[1])
        density = replay_sampling.pdf_light(material, tables, pixel["view"], [to_bits(x) for x in drawn])
    own = replay_sampling.pdf_light(material, tables, pixel["view"], pixel["light"])
    return [("drawn", drawn), ("density", [density, own, 0.0])]


def main():
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("directory")
    parser.add_argument("--pixels", type=int, default=1 << 30, metavar="N", help="pixels of each vector, at most")
    options = parser.parse_args()
    with open(os.path.join(options.directory, "manifest.json"), encoding="utf-8") as file:
        manifest = json.load(file)
    checked = different = 0
    told = {}
    for vector in manifest["vectors"]:
        material = Material(os.path.join(options.directory, vector["material"]), vector)
        images = {}
        for plane in ("uv", "light", "view", "radiance", "picked"):
            images[plane] = next(iter(read_exr(os.path.join(options.directory, vector[plane])).values()))
        size = images["uv"].width
        tables = read_tables(options.directory, vector, material, images) if "tables" in vector else None
        for i in range(min(size * images["uv"].height, options.pixels)):
            pixel = {plane: [image.channels[c][i // size][i % size] for c in "RGB"] for plane, image in images.items()}
            random = random_numbers((i % size, i // size, vector["number"]))
            answers = [(plane, material.evaluate(pixel["uv"][:2], pixel["light"], pixel["view"], numbers))
                       for plane, numbers in (("radiance", None), ("picked", random))]
            answers += sampled(material, tables, pixel, random) if tables else []
            for plane, answer in answers:
                got = [to_bits(x) for x in answer]
                checked += 1
                if got == pixel[plane]:
                    continue
                different += 1
                told[plane] = told.get(plane, 0) + 1
                if told[plane] <= 10:
                    print("%s (%s) pixel %d: %s is %s, the vector has %s" % (
                        vector["material"], vector["about"], i, plane, " ".join("%08x" % g for g in got),
                        " ".join("%08x" % g for g in pixel[plane])), file=sys.stderr)
    print("%d vectors, %d evaluations, %d differ" % (len(manifest["vectors"]), checked, different))
    return 7 if different or not checked else 0


if __name__ == "__main__":
    sys.exit(main())
