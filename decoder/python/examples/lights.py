#!/usr/bin/env python3
"""How bright a surface is under each light, seen from above, whatever it is stored as: a folder or a zip of images
(UBO2003, UTIA), a Bonn .btf file, or a material. Several are set against the first, which takes the same lights.

    lights.py PATH [PATH...]

SPDX-License-Identifier: MIT
"""
import sys

import numpy as np
import openbtf


def open_any(path):
    """A material, or a data set: both have `views`, `lights` and `image(view, light)`."""
    try:
        return openbtf.open(path)
    except openbtf.Error: # no material
        return openbtf.read(path)


def profile(btf):
    """float (lights, 3): mean radiance of all texels from the view nearest to the normal."""
    above = int(btf.views[:, 2].argmax())
    return np.stack([btf.image(above, light).mean((0, 1)) for light in range(len(btf.lights))])


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit("usage: lights.py PATH [PATH...]")
    first = None
    for path in sys.argv[1:]:
        btf = open_any(path)
        bright = profile(btf)
        print(btf)
        for light, rgb in zip(btf.lights, bright):
            theta = np.degrees(np.arccos(np.clip(light[2], -1, 1)))
            phi = np.degrees(np.arctan2(light[1], light[0])) % 360
            print("  light %5.1f, %5.1f: %.4f %.4f %.4f" % (theta, phi, *rgb))
        if first is None:
            first, lights = bright, btf.lights
        elif first.shape == bright.shape and np.allclose(lights, btf.lights, atol=1e-3):
            print("  RMS against the first: %.5f" % np.sqrt(np.mean((bright - first) ** 2)))
        else:
            print("  has other lights than the first")
