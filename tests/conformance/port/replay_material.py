"""A material and its evaluation (FORMAT.md, sections 2 to 5 and 9): for replay.py.

SPDX-License-Identifier: MIT
"""
import math

from replay_arithmetic import add, f32, kept, mul, of_bits, owner, power
from replay_directions import Directions, shared_light, slope
from replay_exr import read_exr


# Of each class: bits of w and of u, components a word, texels of u a unit, tier, shift.
CLASSES = [(8, 8, 4, 1, 0, 4), (4, 8, 8, 2, 1, 5), (4, 4, 8, 1, 1, 1), (2, 4, 16, 2, 2, 0), (2, 2, 16, 1, 2, 0)]


def place_of_u(c, i):
    """The texel of its unit and the lowest bit of the u of component i of a word."""
    return [(0, 8 * i),
            (i % 4 // 2, 8 * (i % 2) + 16 * (1 - i // 4)),
            (0, 4 * (i ^ 4)),
            (i % 8 // 4, 4 * (i % 4) + 16 * (1 - i // 8)),
            (0, 8 * (3 - i // 4) + 2 * (i % 4))][c]


def sheet(part, channel, width, height, count, layer, x, y):
    """A number of layer `layer` of `count` in a contact sheet."""
    grid = math.isqrt(count - 1) + 1
    return part.channels[channel][layer // grid * height + y][layer % grid * width + x]


class Material:
    """A material file, and how it is to be decoded."""

    def __init__(self, path, how):
        self.parts = read_exr(path)
        head = next(iter(self.parts.values()))
        for part in self.parts.values():
            if "openbtf.version" in part.attributes:
                head = part
        level = how["level"]
        assert 0 <= level < head.integer("openbtf.levels", 1), path
        self.width, self.height = (max(1, head.integer("openbtf." + side) >> level) for side in ("width", "height"))
        if level > 0:
            self.parts.update({name[len("level%d." % level):]: part for name, part in self.parts.items()
                               if name.startswith("level%d." % level)})
        self.paper = head.text("openbtf.layout") == "paper"
        self.root = head.text("openbtf.domain") == "sqrt"
        self.colour, self.lobes = head.text("openbtf.colour"), head.integer("openbtf.lobes")
        self.stored = set(filter(None, head.text("openbtf.effects").split(",")))
        self.effects = self.stored & set(how["effects"].split(","))
        self.centres = head.integer("openbtf.centres")
        self.all_components = head.integer("openbtf.residual")
        self.components = min(self.all_components, how["components"]) if "residual" in self.effects else 0
        self.scales = head.floats("openbtf.residualScales")
        self.classes, self.horizon_scale = None, 1.0
        if head.integer("openbtf.version") >= 2 and "openbtf.factorClasses" in head.attributes:
            numbers = [int(x) for x in head.floats("openbtf.factorClasses")]
            self.classes = [tuple(numbers[i:i + 3]) for i in range(0, 15, 3)]
            self.scales = head.floats("openbtf.factorScales")
            self.view_factors = head.floats("openbtf.factorViews")
            self.horizon_scale = head.floats("openbtf.horizonScale")[0]
        store = "separate"
        if head.integer("openbtf.version") >= 2 and "openbtf.pointStore" in head.attributes:
            store = head.text("openbtf.pointStore")
        self.packed = store in ("packed", "lists")
        self.entries = head.integer("openbtf.pointEntries") if store == "lists" else 0
        if self.packed:
            self.gain_base, self.gain_step = (head.floats("openbtf.gain" + name)[0] for name in ("Base", "Step"))
        self.blend_roots = "openbtf.blend" in head.attributes and head.text("openbtf.blend") == "roots"
        self.radiance_scale, self.shadow_scale, self.gain_scale, self.centre_scale = (
            head.floats("openbtf.%sScale" % name)[0] for name in ("radiance", "shadow", "gain", "centre"))
        self.atlas = (head.integer("openbtf.atlasWidth", 0), head.integer("openbtf.atlasHeight", 0))
        self.n_views = len(head.floats("openbtf.views")) // 3
        self.n_lights = len(head.floats("openbtf.lights")) // 3
        self.views, self.lights = Directions(head, "view"), Directions(head, "light")
        self.nearest, self.bilinear = how["interpolation"] == "nearest", how["filter"] != "texel"
        self.steep = how["filter"] == "steep"
        numbers = head.floats("openbtf.views")
        self.view_vectors = [numbers[i:i + 3] for i in range(0, len(numbers), 3)]
        self.gloss = head.integer("openbtf.glossShare") if "gloss" in self.effects else 0
        if "relief" in self.effects:
            self.base, self.step, self.steps = (head.integer("openbtf.relief" + name) for name in ("Base", "Step", "Steps"))
            self.down = 12 + level + head.integer("openbtf.reliefLevel", 0)
            self.acts = [int(x) for x in head.floats("openbtf.reliefViews")]
            if level >= head.integer("openbtf.reliefEnd", head.integer("openbtf.levels", 1)):
                self.effects -= {"relief"}

    def tile(self, channel, i, x, y):
        """A channel of a tile of the atlas."""
        columns = self.atlas[0] // self.width
        return int(self.parts["maps"].channels[channel][i // columns * self.height + y]
                   [i % columns * self.width + x])

    def shadow(self, x, y, light):
        """A shadow code."""
        if self.paper:
            return self.tile("R", light, x, y)
        return int(sheet(self.parts["shadow"], "Y", self.width, self.height, self.n_lights, light, x, y))

    def point(self, x, y, view):
        """A packed point: gain code, or None, and shift bytes."""
        part, size = self.parts.get("points"), (self.width, self.height, self.n_views, view, x, y)
        if self.entries:
            both = int(sheet(self.parts["point_indices"], "R", self.width, self.height, (self.n_views + 1) // 2,
                             view // 2, x, y))
            entry = both // 16 if view % 2 else both % 16
            part, size = self.parts["point_lists"], (self.width, self.height, self.entries, entry, x, y)
        low, high = (int(sheet(part, c, *size)) for c in "RG")
        columns, rows = low % 64 - 32, low // 64 + high % 16 * 4 - 32
        if "shift" not in self.effects:
            columns, rows = 0, 0
        return high // 16 if "gain" in self.effects else None, columns % 256, rows % 256

    def codes(self, x, y, view):
        """Gain code and shift bytes, as this decoder sees them."""
        gain, b0, b1 = 128, 0, 0
        marked = "hidden" in self.stored
        if self.paper:
            if self.stored & {"gain", "hidden"}:
                gain = self.tile("G", view, x, y)
            if self.stored & {"shift", "hidden"}:
                b0, b1 = self.tile("B", view, x, y), self.tile("A", view, x, y)
        else:
            size = (self.width, self.height, self.n_views, view, x, y)
            if "gain" in self.parts:
                gain = int(sheet(self.parts["gain"], "Y", *size))
            if "shift" in self.parts:
                b0, b1 = (int(sheet(self.parts["shift"], c, *size)) for c in "RG")
        if gain == 0 and marked and "hidden" in self.effects:
            return 0, b0, b1
        if gain == 0 or "shift" not in self.effects:
            b0, b1 = 0, 0
        if gain == 0 or "gain" not in self.effects:
            gain = None
        return gain, b0, b1

    def centre(self, i, light):
        """The RGB codes of a centre."""
        if self.paper:
            width, height = self.atlas
            columns, tiles = width // self.width, max(self.n_views, self.n_lights)
            part, y0 = tiles % columns, tiles // columns * self.height
            bands = (height - y0) // self.n_lights
            narrow = min(bands, -(-self.height // self.n_lights)) if part > 0 else 0
            w0 = width - part * self.width
            if i < narrow * w0:
                band, x = i // w0, part * self.width + i % w0
            else:
                rest = i - narrow * w0
                band, x = narrow + rest // width, rest % width
            texels, y = self.parts["maps"].channels, y0 + band * self.n_lights + light
        else:
            blocks = -(-self.centres // 4096)
            rows = -(-self.centres // blocks)
            texels, x, y = self.parts["centres"].channels, i // rows * self.n_lights + light, i % rows
        return [int(texels[c][y][x]) for c in "RGB"]

    def parameter(self, channel, x, y):
        """A channel of `sbrdf` as a float."""
        part = self.parts["sbrdf"]
        value = part.channels[channel][y][x]
        return value if dict(part.order)[channel] == 1 else of_bits(value)

    def sbrdf(self, x, y, product):
        """The Lafortune model."""
        value = lambda name: self.parameter(name, x, y)
        lobes = []
        for j in range(1, self.lobes + 1):
            c = [value("lobe%d.%s" % (j, name)) for name in ("Cx", "Cy", "Cz", "n")]
            b = add(add(mul(c[0], product[0]), mul(c[1], product[1])), mul(c[2], product[2]))
            lobes.append(power(b, c[3]))
        f = [value(c) for c in "RGB"]
        if self.colour == "mono":
            s = value("rho_d")
            for q in lobes:
                s = add(s, q)
            return [mul(c, s) for c in f]
        for j, q in enumerate(lobes, 1):
            f = [add(f[c], mul(value("lobe%d.%s" % (j, "RGB"[c])), q)) for c in range(3)]
        return f

    def residual(self, x, y, view, lights):
        """The low-rank terms."""
        r = [0.0] * 3
        texels, directions = self.parts["residual_texels"], self.parts["residual_directions"]
        for j in range(self.components):
            u = int(sheet(texels, "Y", self.width, self.height, self.all_components, j, x, y))
            factor = mul(float(u), mul(self.scales[j], 2.0 ** -12))
            for c in range(3):
                t = sum(w * int(sheet(directions, "RGB"[c], self.n_lights, self.n_views, self.all_components, j, i,
                                      view)) for i, w in lights)
                r[c] = add(r[c], mul(factor, float(t)))
        return r

    def levels(self, words, which, c):
        """Levels of a word: of w (`which` 0) or, from the words of its one or two texels, of u (1)."""
        bits = CLASSES[c][which]
        for i in range(CLASSES[c][2]):
            texel, at = (0, bits * i) if which == 0 else place_of_u(c, i)
            code = words[texel] >> at & ((1 << bits) - 1)
            yield (code - 256 * (code > 127)) if c == 0 else 2 * code - ((1 << bits) - 1)

    def units(self):
        """Class, number in it, and first layer of u of each unit that is decoded."""
        layer, left = 0, self.components
        for c, (count, _, _) in enumerate(self.classes):
            for number in range(min(count, left)):
                yield c, number, layer + number * CLASSES[c][3]
            layer += count * CLASSES[c][3]
            left -= min(count, left)

    def factors(self, x, y, view, lights):
        """The residual from factors."""
        layers = sum(count * CLASSES[c][3] for c, (count, _, _) in enumerate(self.classes))
        tiers = [[0.0] * 3 for _ in range(3)]
        texels, directions = self.parts["factor_texels"], self.parts["factor_directions"]
        for unit, (c, number, layer) in enumerate(self.units()):
            _, _, _, u_texels, tier, shift = CLASSES[c]
            sums = []
            for channel in "RGBA":
                words = [sheet(texels, channel, self.width, self.height, layers, layer + t, x, y) for t in range(u_texels)]
                u, e = list(self.levels(words, 1, c)), 0
                for light, weight in lights:
                    word = sheet(directions, channel, self.n_lights, self.n_views, self.all_components, unit, light, view)
                    e += weight * sum(a * b for a, b in zip(self.levels([word], 0, c), u))
                sums.append(e)
            _, c1, c2 = self.classes[c]
            scales = self.scales[4 * unit:4 * unit + 4]
            entries = [(s, scale, 1 if k < c1 else 2 if k < c1 + c2 else 0)
                       for k, (s, scale) in enumerate(zip(sums, scales), 4 * number)]
            if c > 0 and 4 * number >= c1 + c2:
                entries = [(sum(sums), scales[0], 0)]
            for e, scale, channel in entries:
                value = mul(f32(e >> shift), mul(scale, 2.0 ** (shift - 12)))
                tiers[tier][channel] = add(tiers[tier][channel], value)
        total = [0.0] * 3
        for tier, p in enumerate(tiers):
            at = 9 * view + 3 * tier
            total = [add(t, mul(v, f)) for t, v, f in zip(total, p, self.view_factors[at:at + 3])]
        luma, c1, c2 = total
        return [add(add(luma, c1), c2), add(luma, -add(c2, c2)), add(add(luma, -c1), c2)]

    def view_radiance(self, x, y, view, lights, product, m, horizon):
        """Radiance of a texel in one sampled view, before radianceScale; its root where roots are blended."""
        gain, b0, b1 = self.point(x, y, view) if self.packed else self.codes(x, y, view)
        if gain == 0 and not self.packed:
            totals = [0, 0, 0]
            for i, w in lights:
                totals = [t + w * code for t, code in zip(totals, self.centre(b0 + 256 * b1, i))]
            scaled = [mul(float(t), mul(self.centre_scale, 2.0 ** -12)) for t in totals]
            return scaled if self.blend_roots else [mul(v, v) for v in scaled]
        x = (x + b0 - (256 if b0 > 127 else 0)) % self.width
        y = (y + b1 - (256 if b1 > 127 else 0)) % self.height
        h = None
        if self.colour != "none":
            h = self.sbrdf(x, y, product)
            if "shadow" in self.effects:
                total = sum(w * self.shadow(x, y, i) for i, w in lights)
                factor = mul(float(total), mul(self.shadow_scale, 2.0 ** -12))
                h = [mul(v, factor) for v in h]
        if self.components and self.classes:
            values = [mul(v, horizon) for v in self.factors(x, y, view, lights)]
            if h is not None:
                values = [add(mul(a, m), b) for a, b in zip(h, values)]
        else:
            if self.components:
                r = self.residual(x, y, view, lights)
                h = r if h is None else [add(a, b) for a, b in zip(h, r)]
            values = [mul(v, m) for v in h or [0.0] * 3]
        if gain is not None:
            factor = mul(float(gain), self.gain_step if self.packed else self.gain_scale)
            factor = add(self.gain_base, factor) if self.packed else factor
            values = [mul(v, factor) for v in values]
        if self.blend_roots:
            return [min(max(v, -(2.0 ** 32)), 2.0 ** 32) for v in values]
        values = [kept(v) for v in values]
        return [mul(v, v) for v in values] if self.root else values

    def scaled(self, total):
        """Radiance from the sum over views."""
        if self.blend_roots:
            total = [mul(kept(t), kept(t)) for t in total]
        return [mul(t, self.radiance_scale) for t in total]

    def texel(self, x, y, views, lights, product, m, horizon):
        """Radiance of a texel; `lights` of each view."""
        total = [0.0] * 3
        for (view, w), of_view in zip(views, lights):
            weight = mul(float(w), 2.0 ** -12)
            radiance = self.view_radiance(x, y, view, of_view, product, m, horizon)
            total = [add(t, mul(v, weight)) for t, v in zip(total, radiance)]
        return self.scaled(total)

    def around(self, t, size):
        """The texels that the filter takes for a position in 1/256 of a texel, wrapped, and their weights."""
        if not self.bilinear:
            return [(t >> 8, 256)]
        t = (t - 128) % (size << 8)
        f = t & 255
        f = min(max(2 * f - 128, 0), 256) if self.steep else f
        return [(t >> 8, 256 - f), (((t >> 8) + 1) % size, f)]

    def moved(self, x, z, s):
        """Section 9's move(); Python's >> rounds down."""
        return [c + ((z * k) >> self.down) for c, k in zip(x, s)]

    def march(self, x, s):
        """The height that is met."""
        top = self.base + ((255 * self.step) >> 8)
        down = (top - self.base + self.steps - 1) // self.steps
        for n in range(self.steps + 1):
            z = top - n * down
            column, v = ((c >> 8) % size for c, size in zip(self.moved(x, z, s), (self.width, self.height)))
            code = int(self.parts["heights"].channels["Y"][self.height - 1 - v][column])
            t = self.base + ((code * self.step) >> 8)
            if t >= z:
                return z if n == 0 else t if t < z + down else z + (down >> 1)
        return self.base

    def shifted(self, x, views, view):
        """Where each view shows what is seen at x, and the weights of views."""
        e = sum(w * self.acts[i] for i, w in views)
        s = [(c * e) >> 12 for c in slope(view)]
        z = self.march(x, s) if self.step > 0 else self.base
        places, weights = [], []
        for i, w in views:
            own = [(c * e) >> 12 for c in slope(self.view_vectors[i])]
            place = [a - b for a, b in zip(self.moved(x, z, s), self.moved((0, 0), z, own))]
            places.append([c % (size << 8) for c, size in zip(place, (self.width, self.height))])
            if self.step > 0 and not self.nearest:
                above = ((self.march(places[-1], own) - z) * e) >> 12
                w *= min(max(6144 - 8 * (above >> (self.down - 12)), 1229), 4096)
            weights.append(w)
        if self.step > 0 and not self.nearest:
            total = sum(weights)
            weights = [((w >> 6) << 12) // (total >> 6) for w in weights[:-1]]
            weights.append(4096 - sum(weights))
        return places, weights

    def shown(self, x, views, lights, view, rest):
        """Radiance with relief: each view at its own texels."""
        total = [0.0] * 3
        for (i, _), of_view, place, w in zip(views, lights, *self.shifted(x, views, view)):
            if w == 0:
                continue
            seen = None
            columns, rows = (self.around(c, size) for c, size in zip(place, (self.width, self.height)))
            for row, wv in rows:
                for column, wu in columns:
                    values = self.view_radiance(column, self.height - 1 - row, i, of_view, *rest)
                    if self.bilinear:
                        values = [mul(v, mul(float(wu * wv), 2.0 ** -16)) for v in values]
                    seen = values if seen is None else [add(a, b) for a, b in zip(seen, values)]
            total = [add(t, mul(v, mul(float(w), 2.0 ** -12))) for t, v in zip(total, seen)]
        return self.scaled(total)

    def picked(self, position, views, lights, view, rest, random):
        """Radiance of one view, light and texel, which random numbers pick."""
        places, weights = [position] * len(views), [w for _, w in views]
        if "relief" in self.effects:
            places, weights = self.shifted(position, views, view)
        a = owner(weights, random[0] >> 20)
        light = lights[a][owner([w for _, w in lights[a]], random[1] >> 20)][0]
        texel = []
        for c, size, number in zip(places[a], (self.width, self.height), (random[2] >> 24, random[2] >> 16 & 255)):
            near, *far = self.around(c, size)
            texel.append(far[0][0] if far and number < far[0][1] else near[0])
        values = self.view_radiance(texel[0], self.height - 1 - texel[1], views[a][0], [(light, 4096)], *rest)
        return self.scaled(values)

    def evaluate(self, uv, light, view, random=None):
        """Radiance (section 9); arguments are bits. With random numbers, of one neighbour that they pick."""
        for direction in (light, view):
            if any((c & 0x7FFFFFFF) > 0x40000000 for c in direction):
                return [0.0] * 3
            if not of_bits(direction[2]) >= 2.0 ** -24:
                return [0.0] * 3
        light, view = ([of_bits(c) for c in d] for d in (light, view))
        views = self.views.neighbours(view, self.nearest)
        if self.gloss:
            lights = [self.lights.neighbours(c, self.nearest, k) for c, k in
                      (shared_light(light, view, self.view_vectors[i], self.gloss) for i, _ in views)]
        else:
            lights = [self.lights.neighbours(light, self.nearest)] * len(views)
        product = [mul(a, b) for a, b in zip(light, view)]
        m = power(light[2], 0.5) if self.root else light[2]
        horizon = mul(light[2], self.horizon_scale)
        horizon = 1.0 if horizon >= 1 else power(horizon, 0.5) if self.root else horizon
        position = []
        for c, size in zip(uv, (self.width, self.height)):
            magnitude = c & 0x7FFFFFFF
            value = of_bits(c) if 0x00800000 <= magnitude <= 0x45800000 else 0.0
            position.append(((math.floor(value * 2.0 ** 18) & 0x3FFFF) * size) >> 10)
        if random:
            return self.picked(position, views, lights, view, (product, m, horizon), random)
        if "relief" in self.effects:
            return self.shown(position, views, lights, view, (product, m, horizon))
        places = [self.around(t, size) for t, size in zip(position, (self.width, self.height))]
        total = None
        for row, wv in places[1]:
            for column, wu in places[0]:
                radiance = self.texel(column, self.height - 1 - row, views, lights, product, m, horizon)
                if not self.bilinear:
                    return radiance
                weighted = [mul(v, mul(float(wu * wv), 2.0 ** -16)) for v in radiance]
                total = weighted if total is None else [add(a, b) for a, b in zip(total, weighted)]
        return total
