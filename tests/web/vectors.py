#!/usr/bin/env python3
"""Converts the test vectors of btf-conform for a page: vectors.py REPLAY_EXR.PY VECTORS OUT.

OUT gets the materials, NN.bin beside each (for each of its pixels 14 words of 32 bits: uv 2, light 3, view 3, radiance 3, picked
3), and vectors.json, the manifest's list with the size of a vector's side.

SPDX-License-Identifier: MIT
"""
import importlib.util
import json
import os
import shutil
import struct
import sys

replay_path, vectors, out = sys.argv[1:]
spec = importlib.util.spec_from_file_location("replay_exr", replay_path)
replay = importlib.util.module_from_spec(spec)
spec.loader.exec_module(replay)

PLANES = (("uv", 2), ("light", 3), ("view", 3), ("radiance", 3), ("picked", 3))

os.makedirs(out, exist_ok=True)
with open(os.path.join(vectors, "manifest.json"), encoding="utf-8") as file:
    listed = json.load(file)["vectors"]
for vector in listed:
    images = {plane: next(iter(replay.read_exr(os.path.join(vectors, vector[plane])).values())) for plane, _ in PLANES}
    side = images["uv"].width
    vector["side"] = side
    words = []
    for row in range(images["uv"].height):
        for column in range(side):
            for plane, channels in PLANES:
                words += [images[plane].channels[c][row][column] for c in "RGB"[:channels]]
    vector["data"] = vector["material"].replace(".btf.exr", ".bin")
    with open(os.path.join(out, vector["data"]), "wb") as file:
        file.write(struct.pack(f"<{len(words)}I", *words))
    shutil.copyfile(os.path.join(vectors, vector["material"]), os.path.join(out, vector["material"]))
with open(os.path.join(out, "vectors.json"), "w", encoding="utf-8") as file:
    json.dump(listed, file)
