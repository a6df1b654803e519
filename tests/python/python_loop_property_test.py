#!/usr/bin/python3
"""A loop of one's own in Python: the C library's ticks, to the bit; meshes, scenes and poses from arrays; types for editors."""
import ast
import ctypes
import math
import os
import threading
import time
import unittest

import numpy as np

import kilotouch as kt
from support import BLOCK, Linear, LIBRARY, ORGAN, QUICK, ROOT, TOP, press


class Pose(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("buttons", ctypes.c_uint32), ("x", ctypes.c_double * 3), ("turn", ctypes.c_double * 4)]


class CFrame(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("flags", ctypes.c_uint32), ("t", ctypes.c_double), ("force", ctypes.c_double * 3)]


class Ticks(unittest.TestCase):
    def test_tick_is_that_of_the_c_library(self):
        if not os.path.exists(LIBRARY):
            self.skipTest("no C library: " + LIBRARY)
        library = ctypes.CDLL(LIBRARY)
        library.kt_open_mesh.restype = ctypes.c_void_p
        settings = [b"local.reducer=wall", b"collision.backend=brute_force"]
        handle = ctypes.c_void_p(library.kt_open_mesh(BLOCK.encode(), (ctypes.c_char_p * 2)(*settings), ctypes.c_size_t(2)))
        touch = kt.Touch(kt.Scene(settings={"object.mesh": BLOCK, "local.reducer": "wall", "collision.backend": "brute_force"}))
        pose, frame = Pose(size=ctypes.sizeof(Pose), turn=(1, 0, 0, 0)), CFrame(size=ctypes.sizeof(CFrame))
        for x in press(0.008, 250):
            pose.x[:] = x
            self.assertEqual(library.kt_tick(handle, ctypes.byref(pose), ctypes.c_size_t(1), ctypes.byref(frame)), 0)
            ours = touch.tick(x)
            self.assertEqual((frame.t, *frame.force), (ours.t, *ours.force))
        library.kt_close(handle)
        self.assertGreater(ours.f_n, 0.01)
        self.assertEqual(ours.flags, kt.Flag(0))
        self.assertIn(ours.mode, kt.MODES)

    def test_a_thread_of_the_body_s_own(self):
        touch = kt.Touch(kt.Scene(settings=QUICK))
        touch.place(TOP)
        touch.start()
        until = time.monotonic() + 100  # on a busy machine the body takes its time
        for x in press(0.008, 300):
            frame = touch.tick(x)
            time.sleep(1e-3)

        def moved():
            return np.linalg.norm(touch.positions - touch.mesh.x, axis=1).max()

        while (touch.status.refreshes <= 3 or moved() <= 1e-3) and time.monotonic() < until:
            frame = touch.tick(x)
            time.sleep(1e-3)
        touch.stop()
        self.assertGreater(frame.f_n, 0.01)
        self.assertGreater(touch.status.refreshes, 3)
        self.assertGreater(moved(), 1e-3)

    def test_others_may_ask_while_it_starts(self):
        for _ in range(3):
            touch = kt.Touch(kt.Scene(settings=QUICK))
            touch.place(TOP)
            over = threading.Event()

            def ask():
                while not over.is_set():
                    touch.status, touch.positions
                    touch["contact.mu"] = 0.3

            threads = [threading.Thread(target=ask) for _ in range(2)]
            for thread in threads:
                thread.start()
            touch.start()
            for x in press(0.002, 20):
                touch.tick(x)
            over.set()
            for thread in threads:
                thread.join()
            self.assertEqual(touch["contact.mu"], 0.3)
            touch.stop()

    def test_a_turn_is_a_rotation(self):
        touch = kt.Touch(kt.Scene(settings=QUICK))
        with self.assertRaisesRegex(kt.InputError, "length 0.84"):
            touch.tick([*TOP, 0.6, 0, 0.6, 0])

    def test_settings_while_it_runs(self):
        touch = kt.Touch(kt.Scene(settings=QUICK))
        touch["contact.mu"] = 0.25
        self.assertEqual(touch["contact.mu"], 0.25)
        self.assertEqual(touch["local.reducer"], "wall")
        for key, value in (("contact.mu", -1), ("local.rate_hz", 10), ("no.such", 1), ("local.reducer", "nothing")):
            with self.assertRaises(kt.InputError):
                touch[key] = value
        self.assertEqual(touch["contact.mu"], 0.25)

    def test_two_threads_that_tick_are_told(self):
        # Its model holds up one of them long enough.
        class Slow(Linear):
            def force(self, x, v):
                time.sleep(0.05)
                return super().force(x, v)

        touch = kt.Touch(kt.Scene(settings=QUICK), model=Slow(kt.load_mesh(BLOCK)))
        told = []

        def tick():
            try:
                for x in press(0.008, 50):
                    touch.tick(x)
            except kt.RunError as error:
                told.append(str(error))

        threads = [threading.Thread(target=tick) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertIn("one at a time", " ".join(told))


class Input(unittest.TestCase):
    def test_mesh_from_arrays_gives_the_forces_of_the_file(self):
        mesh = kt.load_mesh(BLOCK)
        copy = kt.Mesh(mesh.x, tetrahedra=mesh.tetrahedra)
        settings = {key: value for key, value in QUICK.items() if key != "object.mesh"}
        path = press(0.008, 100)
        self.assertEqual(kt.Session(kt.Scene(settings=settings), mesh=copy).run(path).hash,
                         kt.Session(kt.Scene(settings=QUICK)).run(path).hash)
        surface = kt.load_mesh(os.path.join(ROOT, "meshes", "pad.off"))
        filled = kt.Touch(kt.Scene(settings={**settings, "object.model.type": "fem"}), mesh=surface).mesh
        self.assertGreater(len(filled.tetrahedra), 100)

    def test_wrong_arrays_are_told(self):
        x = np.eye(4, 3)
        for arguments, words in (((x, [[0, 1, 9]]), r"triangles\[0\]: node 9 is outside 0 .. 4 - 1"),
                                 ((x, [[0, 1, -1]]), "node -1"), ((x, [[0.5, 1, 2]]), "an integer array"),
                                 ((x, [[0, 1]]), r"\(n, 3\)"), ((x[:, :2], [[0, 1, 2]]), r"x: an array of shape \(n, 3\)"),
                                 ((x + np.inf, [[0, 1, 2]]), r"x\[0\]"), ((x,), "has no triangles")):
            with self.assertRaisesRegex(kt.InputError, words):
                kt.Mesh(*arguments)

    def test_scene_keys(self):
        scene = kt.Scene(ORGAN, {"contact.mu": np.float64(0.7)})
        self.assertEqual(scene["contact.mu_kinetic"], 0.7)
        scene["object.model.young"] = 2e4
        self.assertEqual(scene.to_dict()["object"]["model"]["young"], 2e4)
        for key in scene.keys():  # every one is reached
            scene[key]
        before = scene.to_json()
        for key, value, words in (("contact.mu", -1, "must be a number at least 0"), ("contact.mux", 1, "did you mean"),
                                  ("duration", math.nan, "duration")):
            with self.assertRaisesRegex(kt.InputError, words):
                scene[key] = value
        self.assertEqual(scene.to_json(), before)
        with self.assertRaisesRegex(kt.InputError, "did you mean"):
            scene["contact.mus"]
        with self.assertRaises(kt.InputError):
            kt.Scene("/no/such.json")
        with self.assertRaisesRegex(kt.InputError, "names no file"):
            kt.Touch(kt.Scene())
        with self.assertRaises(TypeError):
            scene["contact.mu"] = object()
        self.assertIn("contact.mu", scene)
        self.assertFalse(scene == None)  # noqa: E711
        for key in ("object/mesh", "object~", ""):
            with self.assertRaises(kt.InputError):
                scene[key]
        with self.assertRaisesRegex(kt.InputError, "without ="):
            scene["contact.mu=0.5,"] = 1
        with self.assertRaisesRegex(kt.InputError, "^contact.mu="):  # no option of a command line
            scene["contact.mu"] = -1
        with self.assertRaisesRegex(kt.InputError, "must be a kilotouch.Mesh"):
            kt.Touch(scene, mesh=BLOCK)

    def test_wrong_poses_are_told(self):
        touch = kt.Touch(kt.Scene(settings=QUICK))
        for poses, words in (((), "0 given"), ((TOP, TOP), "2 given"), ((TOP[:2],), "3 numbers"), (("here",), "3 numbers"),
                             ((None,), "3 numbers")):
            with self.assertRaisesRegex(kt.InputError, words):
                touch.tick(*poses)
        with self.assertRaisesRegex(kt.InputError, "dt"):
            touch.tick(TOP, dt=-1)
        self.assertEqual(touch.tick([math.nan, 0, 0]).flags & kt.Flag.BAD_POSE, kt.Flag.BAD_POSE)


class Stubs(unittest.TestCase):
    """What editors and type checkers read says what the module has."""

    def test_names_are_those_of_the_module(self):
        with open(os.path.join(os.path.dirname(kt.__file__), "__init__.pyi")) as file:
            stubs = ast.parse(file.read())

        def names(body):
            found = {}
            for node in body:
                if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                    found[node.name] = node
                elif isinstance(node, ast.AnnAssign):
                    found[node.target.id] = node
                elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Constant):
                    found[node.targets[0].id] = node
            return found

        def public(names):
            return {name for name in names if not name.startswith("_")}

        told = names(stubs.body)
        self.assertEqual(public(told), set(kt.__all__))
        for name, node in told.items():
            if not isinstance(node, ast.ClassDef):
                continue
            real = getattr(kt, name)
            own = {attribute for base in real.__mro__ if base.__module__.startswith("kilotouch") for attribute in vars(base)}
            if name == "Flag":
                own = set(real.__members__)
            if name == "Model":
                own |= {"mesh", "mass", "fixed"}  # of each one
            self.assertEqual(public(names(node.body)), public(own), name)
            for method, its in names(node.body).items():
                text = getattr(getattr(real, method, None), "__doc__", None) or ""
                if isinstance(its, ast.FunctionDef) and text.startswith(method + "(self"):  # as pybind11 writes it
                    given = text.split("\n")[0]
                    for argument in its.args.args[1:] + its.args.kwonlyargs:
                        self.assertIn(argument.arg + ":", given, (name, method))


if __name__ == "__main__":
    unittest.main()
