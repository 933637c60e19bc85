"""The Python package against the C libraries: bits, shapes, lifetimes, threads, messages.

SPDX-License-Identifier: MIT
"""
import ctypes
import doctest
import gc
import glob
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import openbtf
from openbtf import _library as c

ROOT = pathlib.Path(os.environ["BTF_SOURCE_ROOT"])
GOLDEN = sorted(glob.glob(str(ROOT / "tests/data/golden/*.btf.exr")))
SHARED = pathlib.Path(os.environ.get("BTF_SHARED", ROOT.parent / "shared"))


def directions(rng, count):
    d = rng.normal(size=(count, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    d[:, 2] = np.abs(d[:, 2])
    return d.astype(np.float32)


def bits(array):
    return np.ascontiguousarray(array, np.float32).view(np.uint32)


class Materials(unittest.TestCase):
    def by_reference(self, m, uv, l, v, level, options):
        """btf_ref_evaluate for each argument."""
        function = c.reference.btf_ref_evaluate
        function.restype = None
        function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_float, ctypes.c_float] + [ctypes.c_void_p] * 3
        out = np.empty((len(uv), 3), np.float32)
        material = m._reference(level)
        for i in range(len(uv)):
            function(ctypes.byref(material), ctypes.byref(options), uv[i, 0], uv[i, 1], l[i].ctypes.data, v[i].ctypes.data,
                     out[i].ctypes.data)
        return out

    def test_evaluate_has_the_bits_of_the_reference(self):
        self.assertGreater(len(GOLDEN), 8)
        rng = np.random.default_rng(1)
        for path in GOLDEN:
            m = openbtf.open(path)
            uv, l, v = rng.uniform(-1, 2, (300, 2)).astype(np.float32), directions(rng, 300), directions(rng, 300)
            for interpolation, filter, level, effects, components in (
                    ("linear", "texel", 0, None, None), ("nearest", "bilinear", 0, None, 1),
                    ("linear", "steep", m.levels - 1, ["residual", "relief"], 2)):
                mask = 127 if effects is None else sum(openbtf.EFFECTS[e] for e in effects)
                options = c.RefOptions(mask, components or 0xFFFFFFFF, int(interpolation == "linear"),
                                       ["texel", "bilinear", "steep"].index(filter))
                got = m.evaluate(uv, l, v, level, effects, components, interpolation, filter)
                expected = self.by_reference(m, uv, l, v, level, options)
                np.testing.assert_array_equal(bits(got), bits(expected), "%s %s %s" % (path, interpolation, filter))

    def test_threads_and_broadcasting_change_no_bit(self):
        rng = np.random.default_rng(2)
        m = openbtf.open(GOLDEN[-1])
        uv, v = rng.random((100, 90, 2), np.float32), directions(rng, 90)
        l = np.array([0, 0.6, 0.8], np.float32)
        one = m.evaluate(uv, l, v, threads=1)
        self.assertEqual(one.shape, (100, 90, 3))
        np.testing.assert_array_equal(bits(one), bits(m.evaluate(uv, l, v, threads=4)))
        flat = m.evaluate(uv.reshape(-1, 2), np.tile(l, (9000, 1)), np.tile(v, (100, 1)))
        np.testing.assert_array_equal(bits(one).reshape(-1, 3), bits(flat))
        levels = np.arange(90) % m.levels
        mixed = m.evaluate(uv, l, v, levels)
        for k in range(m.levels):
            np.testing.assert_array_equal(bits(mixed[:, levels == k]), bits(m.evaluate(uv[:, levels == k], l, v[levels == k], k)))

    def test_many_threads_of_the_caller(self):
        rng = np.random.default_rng(3)
        m = openbtf.open(GOLDEN[0])
        uv, l, v = rng.random((5000, 2), np.float32), directions(rng, 5000), directions(rng, 5000)
        expected, wrong = openbtf.open(GOLDEN[0]).evaluate(uv, l, v), []

        def work():
            if not np.array_equal(bits(m.evaluate(uv, l, v)), bits(expected)):
                wrong.append(1)

        threads = [threading.Thread(target=work) for _ in range(6)]
        for t in threads:
            t.start()
        for t in threads:
            t.join()
        self.assertEqual(wrong, [])

    def test_image_is_evaluate_at_texel_centres(self):
        for path in GOLDEN:
            m = openbtf.open(path)
            height, width = m.texels
            uv = np.stack(np.meshgrid((np.arange(width) + 0.5) / width, 1 - (np.arange(height) + 0.5) / height), -1)
            image = m.image(1, 2)
            self.assertEqual((image.shape, image.dtype), ((height, width, 3), np.float32))
            np.testing.assert_array_equal(bits(image), bits(m.evaluate(uv, m.lights[2], m.views[1])))
            np.testing.assert_array_equal(bits(image), bits(m.image(m.views[1], m.lights[2])))

    def test_directions_and_textures_outlive_the_material(self):
        m = openbtf.open(GOLDEN[0])
        views, textures = m.views, m.textures()
        before, copies = views.copy(), {name: t.copy() for name, t in textures.items()}
        part = textures["residual_texels"][0]
        del m
        gc.collect()
        others = [openbtf.open(path) for path in GOLDEN]
        np.testing.assert_array_equal(views, before)
        for name, t in textures.items():
            np.testing.assert_array_equal(t, copies[name])
            self.assertFalse(t.flags.writeable)
        np.testing.assert_array_equal(part, copies["residual_texels"][0])
        self.assertEqual(len(others), len(GOLDEN))
        self.assertTrue(np.allclose(np.linalg.norm(views, axis=1), 1, atol=1e-6))

    def test_texture_shapes(self):
        m = openbtf.open(str(ROOT / "tests/data/golden/v1-tight.btf.exr"))
        shapes = {name: (t.shape, t.dtype.name) for name, t in m.textures().items()}
        height, width = m.texels
        self.assertEqual(shapes["shift"], ((len(m.views), height, width, 2), "uint8"))
        self.assertEqual(shapes["shadow"], ((len(m.lights), height, width, 1), "uint8"))
        self.assertIn("shift", m.textures(1))
        self.assertNotIn("view_table", m.textures(1))
        self.assertEqual(m.textures(1)["shift"].shape[1:3], (max(1, height >> 1), max(1, width >> 1)))

    def test_glsl(self):
        m = openbtf.open(GOLDEN[-1])
        text = m.glsl(filter="bilinear", prefix="cloth", effects=["residual"])
        self.assertIn("vec3 cloth_evaluate(", text)
        self.assertNotEqual(text, m.glsl(prefix="cloth"))
        self.assertIn("btf_evaluate_stochastic", m.glsl(picks="all"))
        with self.assertRaisesRegex(openbtf.UsageError, "prefix"):
            m.glsl(prefix="Not Allowed")

    def test_wgsl(self):
        m = openbtf.open(GOLDEN[-1])
        text = m.wgsl(filter="bilinear", prefix="cloth", descriptor_set=2, first_binding=30)
        self.assertIn("fn cloth_evaluate(uv: vec2f, l: vec3f, v: vec3f) -> vec3f {", text)
        self.assertIn("@group(2) @binding(39) var cloth_view_table: texture_2d<u32>;", text)
        self.assertIn("@group(2) @binding(53) var<uniform> cloth_zero: u32;", text)
        self.assertNotIn("cloth_zero", m.wgsl(math="fast", prefix="cloth"))
        self.assertIn("fn btf_evaluate_stochastic(", m.wgsl(picks="all"))

    def test_plan_and_restrict(self):
        m = openbtf.open(str(ROOT / "tests/data/golden/v1-tight.btf.exr"))
        plan = m.plan(view=(0, 40), light=np.array([0, 0, 1], np.float32), tolerance=1)
        small = m.restrict(plan)
        self.assertLessEqual(len(small.views), len(m.views))
        self.assertEqual(set(plan.effects) - set(m.effects), set())
        uv, v = np.random.default_rng(4).random((64, 2), np.float32), np.array([0, 0, 1], np.float32)
        options = dict(effects=plan.effects, components=plan.components or None, interpolation=plan.interpolation, filter=plan.filter)
        np.testing.assert_array_equal(bits(small.evaluate(uv, v, v, **options)), bits(m.evaluate(uv, v, v, level=plan.level, **options)))
        folded, unfolded = m.plan(view=v, light=v), m.plan(view=v, light=v, folds=False)
        self.assertEqual((folded.fold, unfolded.fold), ("both", "none"))
        self.assertLess(folded.price, unfolded.price)
        self.assertEqual(m.plan(view=v, light=(0, 60), lights=3, still_lights=True).fold, "both")
        self.assertEqual(m.plan(view=v, light=(0, 60), lights=3).fold, "none")
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "costs.json")
            pathlib.Path(path).write_text('{"openbtf_costs": 1, "pixel": 7, "look_up": 0, "point": 0, "move": 0, "step": 0, '
                                          '"fetch": 0, "byte": 0, "integer": 0, "float": 0, "masked": 0}')
            self.assertEqual(m.plan(costs=path).full_cost, 7)
            pathlib.Path(path).write_text("{}")
            with self.assertRaisesRegex(openbtf.BadFileError, "costs.json"):
                m.plan(costs=path)
        with self.assertRaisesRegex(openbtf.UsageError, "shape"):
            m.plan(view=(1, 2, 3, 4, 5))

    def test_light_sampling(self):
        m = openbtf.open(GOLDEN[0])
        random = np.random.default_rng(5).integers(0, 2**32, (2, 400), np.uint32)
        l, pdf = m.sample_light([0, 0.6, 0.8], *random)
        self.assertTrue(np.allclose(np.linalg.norm(l, axis=-1), 1, atol=1e-5))
        np.testing.assert_array_equal(bits(pdf), bits(m.pdf_light([0, 0.6, 0.8], l)))
        # The mean of 1 / pdf is the solid angle where pdf > 0: the hemisphere.
        l, pdf = m.sample_light([0, 0, 1], *np.random.default_rng(6).integers(0, 2**32, (2, 20000), np.uint32))
        estimate = 1 / pdf.astype(float)
        self.assertLess(abs(estimate.mean() - 2 * np.pi), 4 * estimate.std() / np.sqrt(len(pdf)))

    def test_stochastic_picks(self):
        m = openbtf.open(str(ROOT / "tests/data/golden/v1-tight.btf.exr"))
        random = np.random.default_rng(7).integers(0, 2**32, (50, 3), np.uint32)
        a = m.evaluate_stochastic([0.3, 0.7], [0.3, 0.2, 0.87**0.5], [0.1, -0.2, 0.95**0.5], random, filter="bilinear")
        self.assertEqual(a.shape, (50, 3))
        self.assertGreater(len(np.unique(bits(a), axis=0)), 1)
        nearest = m.evaluate_stochastic([0.3, 0.7], m.lights[1], m.views[1], random, filter="texel")
        self.assertEqual(len(np.unique(bits(nearest), axis=0)), 1)

    def test_save_and_bytes(self):
        m = openbtf.open(GOLDEN[0])
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "copy.btf.exr"
            m.save(path)
            again = openbtf.open(path.read_bytes())
        np.testing.assert_array_equal(bits(again.image(0, 0)), bits(m.image(0, 0)))

    def test_refusals(self):
        m = openbtf.open(GOLDEN[0])
        for error, text, call in (
                (openbtf.FileError, "none.btf.exr", lambda: openbtf.open("/none.btf.exr")),
                (OSError, "No such file", lambda: openbtf.open("/none")),
                (openbtf.BadFileError, "OpenEXR", lambda: openbtf.open(b"not a material")),
                (openbtf.BadFileError, "", lambda: openbtf.open(pathlib.Path(GOLDEN[0]).read_bytes()[:-40])),
                (ValueError, "uv has shape", lambda: m.evaluate([1, 2, 3], [0, 0, 1], [0, 0, 1])),
                (openbtf.UsageError, "filter is 'cubic'", lambda: m.evaluate([0, 0], [0, 0, 1], [0, 0, 1], filter="cubic")),
                (openbtf.UsageError, "effect is 'glow'", lambda: m.evaluate([0, 0], [0, 0, 1], [0, 0, 1], effects=["glow"])),
                (openbtf.UsageError, "components is 0", lambda: m.image(0, 0, components=0)),
                (openbtf.UsageError, "level has type", lambda: m.evaluate([0, 0], [0, 0, 1], [0, 0, 1], level=0.5)),
                (openbtf.UsageError, "view 99", lambda: m.image(99, 0)),
                (openbtf.UsageError, "level 9", lambda: m.textures(9))):
            with self.assertRaisesRegex(error, text):
                call()


class DataSets(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        rng = np.random.default_rng(8)
        cls.angles = np.array([[0, 0], [40, 10], [40, 130.5], [40, 250]])
        cls.samples = rng.random((4, 4, 6, 5, 3), np.float32)
        cls.path = os.path.join(cls.folder.name, "set")
        openbtf.write(cls.path, cls.samples, cls.angles, cls.angles)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_what_is_written_is_read(self):
        d = openbtf.read(self.path)
        self.assertEqual((d.shape, d.lazy), ((4, 4, 6, 5, 3), True))
        np.testing.assert_array_equal(d[:], self.samples)
        np.testing.assert_array_equal(np.asarray(d), self.samples)
        np.testing.assert_allclose(d.view_angles, self.angles, atol=1e-9)
        np.testing.assert_allclose(openbtf.data.angles(d.views), self.angles, atol=1.01e-4)

    def test_slices(self):
        d, s = openbtf.read(self.path), self.samples
        for key in (0, -1, (1, 2), (slice(None), 3), (slice(1, 3), slice(None, None, 2)), (2, slice(None), slice(2, 4), 1),
                    (Ellipsis, 0), (1, Ellipsis, 2), ([0, 2], 1), (slice(0, 0), 1)):
            np.testing.assert_array_equal(d[key], s[key], str(key))
        with self.assertRaises(IndexError):
            d[0, 0, 0, 0, 0, 0]
        with self.assertRaisesRegex(openbtf.UsageError, "view 4"):
            d.image(4, 0)

    def test_an_archive_and_options(self):
        archive = shutil.make_archive(os.path.join(self.folder.name, "packed"), "zip", self.path)
        d = openbtf.read(archive)
        self.assertFalse(d.lazy)
        np.testing.assert_array_equal(d[:], self.samples)
        np.testing.assert_array_equal(openbtf.read(self.path, flip_v=True)[1, 1], self.samples[1, 1, ::-1])
        np.testing.assert_array_equal(openbtf.read(self.path, crop=(1, 2, 3, 2))[1, 1], self.samples[1, 1, 2:4, 1:4])
        self.assertEqual(openbtf.read(self.path, size=(2, 3)).shape, (4, 4, 3, 2, 3))

    def test_a_bonn_file(self):
        program = os.path.join(os.environ["BTF_BUILD_ROOT"], "tests/tools/bonn_sample")
        path = os.path.join(self.folder.name, "bonn.btf")
        subprocess.run([program, path], check=True)
        d = openbtf.read(path)
        whole = d[:]
        self.assertEqual(whole.shape, d.shape)
        self.assertTrue(np.isfinite(whole).all() and whole.max() > 0)

    def test_encode(self):
        stages = []
        d = openbtf.read(self.path)
        out = os.path.join(self.folder.name, "m.btf.exr")
        m = openbtf.encode(d, out, lambda stage, percent: stages.append((stage, percent)), preset="fast")
        self.assertEqual(stages[-1][1], 100)
        self.assertTrue(all(a[1] <= b[1] for a, b in zip(stages, stages[1:])), stages)
        from_array = openbtf.encode(self.samples, out, views=d.views, lights=self.angles, preset="fast")
        np.testing.assert_array_equal(bits(m.image(1, 1)), bits(from_array.image(1, 1)))
        self.assertEqual(m.texels, (6, 5))

    def test_refusals(self):
        out = os.path.join(self.folder.name, "no.btf.exr")
        empty = os.path.join(self.folder.name, "empty")
        os.makedirs(empty, exist_ok=True)
        for error, text, call in (
                (openbtf.FileError, "/none", lambda: openbtf.read("/none")),
                (openbtf.BadFileError, "", lambda: openbtf.read(empty)),
                (openbtf.UsageError, "0x4", lambda: openbtf.read(self.path, size=(0, 4))),
                (openbtf.UsageError, "transfer is 'film'", lambda: openbtf.read(self.path, transfer="film")),
                (openbtf.UsageError, "not empty", lambda: openbtf.write(self.path, self.samples, self.angles, self.angles)),
                (openbtf.UsageError, "call for", lambda: openbtf.write(out, self.samples, self.angles[:2], self.angles)),
                (openbtf.UsageError, "--budget", lambda: openbtf.encode(self.path, out, budget="much")),
                (openbtf.UsageError, "views and lights", lambda: openbtf.encode(self.samples, out)),
                (openbtf.FileError, "/none", lambda: openbtf.encode("/none", out))):
            with self.assertRaisesRegex(error, text):
                call()
        self.assertFalse(os.path.exists(out))
        broken = self.samples.copy()
        broken[0, 0, 0, 0, 0] = np.nan
        with self.assertRaisesRegex(openbtf.UsageError, "no numbers"):
            openbtf.write(os.path.join(self.folder.name, "nan"), broken, self.angles, self.angles)

    def test_a_damaged_image_is_named(self):
        copy = os.path.join(self.folder.name, "damaged")
        shutil.copytree(self.path, copy)
        file = sorted(pathlib.Path(copy).rglob("*.exr"))[5]
        file.write_bytes(file.read_bytes()[:200])
        d = openbtf.read(copy)
        with self.assertRaisesRegex(openbtf.Error, file.name.replace(".", "\\.")):
            d[:]


class Documents(unittest.TestCase):
    def test_doctests(self):
        tried = 0
        os.environ["OPENBTF_SAMPLE"] = str(ROOT / "tests/data/golden/v1-tight.btf.exr")
        for module in (openbtf, openbtf.material, openbtf.data):
            result = doctest.testmod(module)
            self.assertEqual(result.failed, 0)
            tried += result.attempted
        self.assertGreater(tried, 20)

    def test_everything_has_a_docstring(self):
        for name in openbtf.__all__:
            value = getattr(openbtf, name)
            if callable(value):
                self.assertTrue(value.__doc__, name)
            if isinstance(value, type):
                for member, attribute in vars(value).items():
                    if not member.startswith("_") and (callable(attribute) or isinstance(attribute, property)):
                        self.assertTrue(attribute.__doc__, "%s.%s" % (name, member))


class Lines(unittest.TextTestResult):
    """Prints a line a case, in the form that tests/summary.py counts."""

    def startTest(self, test):
        super().startTest(test)
        print("[ RUN      ] %s" % test.id().split(".", 1)[1])

    def _line(self, verdict, test):
        print("[%10s ] %s" % (verdict, test.id().split(".", 1)[1]), flush=True)

    def addSuccess(self, test):
        super().addSuccess(test)
        self._line("OK", test)

    def addFailure(self, test, err):
        super().addFailure(test, err)
        self._line("FAILED ", test)

    def addError(self, test, err):
        super().addError(test, err)
        self._line("ERROR  ", test)

    def addSkip(self, test, reason):
        super().addSkip(test, reason)
        print("skipped: %s" % reason)
        self._line("SKIPPED", test)


if __name__ == "__main__":
    unittest.main(testRunner=unittest.TextTestRunner(stream=sys.stdout, resultclass=Lines))
