#!/usr/bin/python3
"""Many places of one body: touches that share it, heights, presses at the same time; and the live page of a scene."""
import math
import os
import tempfile
import unittest
import urllib.request

import numpy as np

import kilotouch as kt
from support import BLOCK, ORGAN, PROGRAM, QUICK, ROOT, TOP, press

SCENE = kt.Scene(settings={**QUICK, "tool.shape": "sphere", "tool.radius": 0.004})


class SharedBody(unittest.TestCase):
    def test_forces_are_those_of_a_body_of_its_own(self):
        own = kt.Touch(SCENE)
        alone = [own.tick(x).f_n for x in press(0.008, 100)]
        first = kt.Touch(SCENE)
        second = kt.Touch(SCENE, body_of=first)
        pairs = [(first.tick(x).f_n, second.tick(x).f_n) for x in press(0.008, 100)]
        self.assertEqual([a for a, _ in pairs], alone)
        self.assertEqual([b for _, b in pairs], alone)
        self.assertGreater(max(alone), 0)

    def test_the_body_outlives_the_touch_that_made_it(self):
        first = kt.Touch(SCENE)
        second = kt.Touch(SCENE, body_of=first)
        del first
        self.assertGreater(max(second.tick(x).f_n for x in press(0.008, 100)), 0)

    def test_settings_of_tool_and_contact_are_its_own(self):
        scene = kt.Scene(settings={**QUICK, "contact.mu": 0, "tool.radius": 0.006})
        touch = kt.Touch(scene, body_of=kt.Touch(SCENE))
        self.assertEqual(touch["contact.mu"], 0)

    def test_another_body_is_refused(self):
        first = kt.Touch(SCENE)
        other = kt.Scene(settings={**QUICK, "object.model.young": 2e4})
        with self.assertRaisesRegex(kt.InputError, "body_of: object or global.self_contact of this scene"):
            kt.Touch(other, body_of=first)
        with self.assertRaisesRegex(kt.InputError, "body_of: must be a kilotouch.Touch"):
            kt.Touch(SCENE, body_of=3)
        with self.assertRaisesRegex(kt.InputError, "body_of: give no mesh or model"):
            kt.Touch(SCENE, mesh=kt.load_mesh(BLOCK), body_of=first)

    def test_a_body_with_self_contact_has_one_user(self):
        scene = kt.Scene(settings={**QUICK, "global.self_contact": {}})
        with self.assertRaisesRegex(kt.InputError, "self-contact"):
            kt.Touch(scene, body_of=kt.Touch(scene))


class Heights(unittest.TestCase):
    def test_of_a_block_are_its_top(self):
        mesh = kt.load_mesh(BLOCK)
        low, high = mesh.x.min(0), mesh.x.max(0)
        at = low[:2] + np.random.default_rng(1).random((50, 2)) * (high - low)[:2]
        np.testing.assert_allclose(kt.height(mesh, at), high[2], atol=1e-12)
        np.testing.assert_allclose(kt.height(mesh, mesh.x[:, :2]), high[2], atol=1e-12)  # over nodes and edges
        self.assertTrue(math.isnan(kt.height(mesh, high[:2] + 1e-3)))

    def test_follow_the_body(self):
        touch = kt.Touch(SCENE)
        before = kt.height(touch, TOP[:2])  # from here on positions have the part around the contact as it was some ticks ago
        for x in [*press(0.008, 100), *np.repeat(press(0.008, 1)[-1:], 40, 0)]:
            touch.tick(x)
        kt.height(touch, TOP[:2])
        for x in np.repeat(press(0.008, 1)[-1:], 40, 0):
            touch.tick(x)
        self.assertLess(kt.height(touch, TOP[:2]), before - 1e-3)

    def test_of_a_cap_are_those_of_its_sphere(self):
        x, y = np.meshgrid(np.linspace(-1, 1, 201), np.linspace(-1, 1, 201), indexing="ij")
        grid = np.arange(201 * 201).reshape(201, 201)
        a, b, c, d = grid[:-1, :-1].ravel(), grid[1:, :-1].ravel(), grid[1:, 1:].ravel(), grid[:-1, 1:].ravel()
        cap = np.stack([x.ravel(), y.ravel(), np.sqrt(np.maximum(0, 4 - x.ravel() ** 2 - y.ravel() ** 2))], 1)  # of a ball of radius 2
        mesh = kt.Mesh(cap, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]), None)
        at = np.random.default_rng(2).uniform(-0.9, 0.9, (20, 2))
        np.testing.assert_allclose(kt.height(mesh, at), np.sqrt(4 - (at ** 2).sum(1)), atol=2e-5)

    def test_wrong_shapes_are_told(self):
        with self.assertRaisesRegex(kt.InputError, r"xy: shape \(3,\), must be"):
            kt.height(kt.load_mesh(BLOCK), [0, 0, 0])


class Presses(unittest.TestCase):
    def test_are_those_of_a_loop_whatever_the_number_of_jobs(self):
        at = np.array([[0.02, 0.02], [0.03, 0.026], [0.04, 0.03], [9, 9]])
        one, many = (kt.press(SCENE, at, 0.002, jobs=jobs) for jobs in (1, 4))
        for name in one:
            np.testing.assert_array_equal(one[name], many[name])
        self.assertTrue(np.isnan(one["f_n"][3]) and np.isnan(one["height"][3]))
        self.assertTrue((one["f_n"][:3] > 0.01).all(), one["f_n"])
        touch, ticks = kt.Touch(SCENE), 84
        for k in range(ticks + 11):
            frame = touch.tick([0.03, 0.026, one["height"][1] + 0.004 + 0.0001 - min(1, k / ticks) * 0.0021])
        self.assertAlmostEqual(frame.f_n, one["f_n"][1], delta=1e-4 * frame.f_n)  # it begins a tick sooner

    def test_wrong_input_is_told(self):
        for wrong, words in ((dict(depth=0), "depth: 0, must be above 0"), (dict(depth=1e-3, speed=math.inf), "speed: inf"),
                             (dict(depth=1e-3, rest=-1), "rest: -1")):
            with self.assertRaisesRegex(kt.InputError, words):
                kt.press(SCENE, [[0.03, 0.026]], **wrong)
        with self.assertRaisesRegex(kt.InputError, r"xy: shape \(2,\)"):
            kt.press(SCENE, [0.03, 0.026], 1e-3)
        with self.assertRaisesRegex(kt.InputError, "tool.shape: capsule"):
            kt.press(kt.Scene(settings={**QUICK, "tool.shape": "capsule"}), [[0.03, 0.026]], 1e-3)


class Pages(unittest.TestCase):
    def setUp(self):
        path = os.environ["PATH"]
        os.environ["PATH"] = os.path.dirname(PROGRAM) + os.pathsep + path
        self.addCleanup(os.environ.__setitem__, "PATH", path)

    def page(self, what):
        with kt.view(what, open=False) as server:
            self.assertIn(server.url, server._repr_html_())
            with urllib.request.urlopen(server.url) as answer:
                self.assertIn("<title>kilotouch", answer.read().decode())
            pid = server._server.pid
        self.assertRaises(ProcessLookupError, os.kill, pid, 0)

    def test_of_a_scene_and_of_a_mesh_open_and_end(self):
        self.page(SCENE)
        self.page(kt.load_mesh(BLOCK))

    def test_of_a_scene_that_names_its_mesh_from_its_own_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            here = os.getcwd()
            self.addCleanup(os.chdir, here)
            os.chdir(folder)
            self.page(kt.Scene(os.path.relpath(ORGAN), {"local.reducer": "wall"}))
            os.chdir(here)

    def test_a_refusal_is_the_command_s(self):
        with self.assertRaisesRegex(kt.RunError, "nothing.json"):
            kt.view(os.path.join(ROOT, "nothing.json"), open=False)
        with self.assertRaisesRegex(kt.InputError, "object.mesh: the scene names no file"):
            kt.view(kt.Scene(), open=False)
        os.environ["PATH"] = "/nonexistent"
        with self.assertRaisesRegex(kt.RunError, "install the package kilotouch"):
            kt.view(SCENE, open=False)


if __name__ == "__main__":
    unittest.main(verbosity=2)
