#!/usr/bin/python3
"""What the C interface and the Python package are given and give: turned arrays, huge counts, wrong order; copies, warnings, a new start."""
import copy
import ctypes
import math
import os
import pickle
import subprocess
import sys
import unittest

import numpy as np

import kilotouch as kt
from kilotouch import _kilotouch
from support import BLOCK, LIBRARY, QUICK, TOP, press

INPUT, RUN, MISUSE = 1, 2, 3
THROUGH = "the tool went into the body or through it unstopped in 1 tick, first in tick 50 (t = 0.051 s), 0.4 m in that one"


class Pose(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("buttons", ctypes.c_uint32), ("x", ctypes.c_double * 3), ("turn", ctypes.c_double * 4)]


class FoundOne(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("weight", ctypes.c_int32), ("value", ctypes.c_double), ("limit", ctypes.c_double), ("what", ctypes.c_char * 512),
                ("where", ctypes.c_char * 64), ("cure", ctypes.c_char * 256), ("cure_key", ctypes.c_char * 64), ("cure_value", ctypes.c_char * 64)]


class Frame(ctypes.Structure):
    _fields_ = [("size", ctypes.c_uint32), ("flags", ctypes.c_uint32), ("t", ctypes.c_double)]


def solid(turned=False, **settings):
    """The block as arrays, its tetrahedra turned the other way or not."""
    block = kt.load_mesh(BLOCK)
    tetrahedra = block.tetrahedra[:, [0, 1, 3, 2]] if turned else block.tetrahedra
    touch = kt.Touch(kt.Scene(settings={**QUICK, "object.mesh": "-", **settings}), mesh=kt.Mesh(block.x, None, tetrahedra))
    return touch


class Arrays(unittest.TestCase):
    def test_tetrahedra_turned_either_way_give_one_force(self):
        for model in ("msd", "fem"):
            right, turned = (solid(t, **{"object.model.type": model}) for t in (False, True))
            for x in press(0.008, 120):
                self.assertAlmostEqual(turned.tick(x).f_n, (f := right.tick(x).f_n), delta=1e-6 * (1 + f))
            self.assertGreater(f, 0.01)

    def test_a_mesh_is_looked_at(self):
        x, cell = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]), [[0, 1, 2, 3]]
        kt.Mesh(x, None, cell)
        for wrong in ((x * math.nan, None, cell), (x, None, [[0, 1, 2, 4]]), (x, None, [[0, 1, 2, 2]]), (x, None, None)):
            with self.assertRaises(kt.InputError) as caught:
                kt.Mesh(*wrong)
            self.assertNotIn("\n", str(caught.exception))

    def test_messages_of_arrays_name_the_given_mesh(self):
        open_sheet = kt.Mesh([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 1, 2]])
        with self.assertRaises(kt.InputError) as caught:
            kt.Touch(kt.Scene(), mesh=open_sheet)
        self.assertTrue(str(caught.exception).startswith("the given mesh"), caught.exception)

    def test_no_memory_is_an_exception(self):
        text = """if True:
            import resource, numpy as np, kilotouch as kt
            resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
            try:
                kt.Mesh(np.broadcast_to(np.float64(0), (10**9, 3)), [[0, 1, 2]])
            except MemoryError:
                print("told")"""
        run = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"})
        self.assertEqual((run.returncode, run.stdout.strip()), (0, "told"), run.stderr)


class Objects(unittest.TestCase):
    def test_scene_mesh_and_frame_are_copied_and_pickled(self):
        scene, mesh = kt.Scene(settings=QUICK), kt.load_mesh(BLOCK)
        frame = [kt.Touch(scene).tick(TOP)][0]
        for again in (lambda o: pickle.loads(pickle.dumps(o)), copy.copy, copy.deepcopy):
            self.assertEqual(again(scene), scene)
            self.assertEqual(again(scene)["tool.path.press_drag.depth"], 0.003)
            self.assertIs(type(again(scene)), kt.Scene)
            for name in ("x", "triangles", "tetrahedra"):
                self.assertTrue((getattr(again(mesh), name) == getattr(mesh, name)).all())
            for name in ("t", "f_n", "gap", "mode", "triangle", "flags", "model_frame"):
                self.assertEqual(getattr(again(frame), name), getattr(frame, name))
            self.assertTrue((again(frame).force == frame.force).all() and (again(frame).turn == frame.turn).all())

    def test_mu_is_what_it_was_set_to(self):
        scene = kt.Scene(settings=QUICK)
        scene["contact.mu"] = 0.7
        self.assertEqual(scene["contact.mu"], 0.7)
        scene["contact.mu_kinetic"] = 0.3
        self.assertIsNone(scene["contact.mu"])

    def test_centre_is_center(self):
        for word in ("center", "centre"):
            scene = kt.Scene(settings={"object.model.inclusions": [{word: [0, 0, 0.01], "radius": 0.01, "stiffer": 3}]})
            self.assertEqual(scene["object.model.inclusions"][0]["center"], [0, 0, 0.01])

    def test_touch_warns_and_starts_anew(self):
        touch = kt.Touch(kt.Scene(settings=QUICK))
        self.assertEqual(touch.warnings, [])
        first = [touch.tick(x).f_n for x in press(0.008, 100)]
        self.assertTrue(math.isinf(kt.Touch(kt.Scene(settings=QUICK)).tick(TOP + [0, 0, 0.05]).gap))
        touch["contact.mu"] = 0.2
        touch.tick([math.nan] * 3)
        self.assertTrue(any("not finite" in w for w in touch.warnings), touch.warnings)
        found = [f for f in touch.findings if "not finite" in f["what"]]
        self.assertEqual((len(found), found[0]["weight"], found[0]["value"], found[0]["limit"]), (1, "doubt", 1, 0))
        touch.reset()
        self.assertEqual(touch["contact.mu"], 0.2)
        self.assertEqual(touch.warnings, [])
        touch["contact.mu"] = 0.5
        self.assertEqual([touch.tick(x).f_n for x in press(0.008, 100)], first)

    def test_episodes_begin_from_a_copied_state(self):
        touch = kt.Touch(kt.Scene(settings=QUICK))
        way = np.vstack([press(0.008, 400), np.repeat(press(0.008, 400)[-1:], 50, 0)])
        for x in way[:400]:
            touch.tick(x)
        state = touch.state
        self.assertEqual(state.positions.shape, touch.positions.shape)
        self.assertEqual(state.velocities.shape, state.positions.shape)
        forces = lambda one: np.array([one.tick(x).force for x in way[400:]])
        on = forces(touch)
        self.assertGreater(np.linalg.norm(on[0]), 0)
        touch.reset(state)
        again = forces(touch)
        self.assertLess(np.linalg.norm(again[0] - on[0]), 0.03 * np.linalg.norm(on[0]))
        other = kt.Touch(kt.Scene(settings=QUICK), body_of=touch)
        other.reset(state)
        self.assertTrue((forces(other) == again).all())
        touch.reset(kt.State(state.positions, 0 * state.velocities))
        self.assertTrue(np.allclose(touch.positions, state.positions, atol=1e-12))
        for wrong in ((state.positions[:2], state.velocities), (state.positions, state.velocities * math.nan)):
            with self.assertRaises(kt.InputError):
                touch.reset(kt.State(*wrong))
        with self.assertRaises(kt.InputError):
            kt.State(state.positions.ravel(), state.velocities)

    def test_a_loop_is_told_what_the_command_tells(self):
        leap = {k: v for k, v in QUICK.items() if "press_drag" not in k}
        high, low = [0.03, 0.026, 0.2], [0.03, 0.026, -0.2]
        path = [[t, *x] for t, x in ((0, high), (0.05, high), (0.0505, low), (0.2, low))]
        trace = kt.Session(kt.Scene(settings={**leap, "duration": 0.2, "tool.path.waypoints": path})).run()
        touch = kt.Touch(kt.Scene(settings=leap))
        touch.place(trace.x[0])
        for x in trace.x:
            touch.tick(x)
        touch.stop()
        said = [[w.split(";")[0] for w in told if THROUGH in w] for told in (trace.warnings, touch.warnings)]
        self.assertEqual(len(said[0]), 1, trace.warnings)
        self.assertEqual(said[1], said[0], touch.warnings)

    def test_wrong_arguments_are_one_line(self):
        for call in (lambda: kt.Touch(3), lambda: kt.Session("a"), lambda: kt.load_mesh(), lambda: kt.DeviceReading(TOP, age="x")):
            with self.assertRaises((TypeError, ValueError)) as caught:
                call()
            self.assertNotIn("\n", str(caught.exception))

    def test_an_object_without_init_is_no_crash(self):
        text = """if True:
            import kilotouch as kt
            from kilotouch import _kilotouch
            for cls, use in ((_kilotouch.Touch, lambda t: t.h), (_kilotouch.Touch, lambda t: t.stop()), (kt.Mesh, lambda m: m.x),
                             (kt.Session, lambda s: s.is_running), (kt.Frame, lambda f: f.t), (kt.PushedDevice, lambda d: d.order)):
                try:
                    use(cls.__new__(cls))
                except TypeError:
                    continue
                raise SystemExit(f"{cls}: no error")"""
        run = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True)
        self.assertEqual(run.returncode, 0, run.stderr + run.stdout)


@unittest.skipUnless(os.path.exists(LIBRARY), "no C library")
class CInterface(unittest.TestCase):
    def setUp(self):
        self.kt = ctypes.CDLL(LIBRARY)
        self.kt.kt_open_mesh.restype = self.kt.kt_open_arrays.restype = ctypes.c_void_p
        self.kt.kt_last_error.restype = ctypes.c_char_p

    def error(self):
        return self.kt.kt_last_error().decode()

    def opened(self, *settings):
        words = (ctypes.c_char_p * len(settings))(*(s.encode() for s in settings))
        return ctypes.c_void_p(self.kt.kt_open_mesh(BLOCK.encode(), words, ctypes.c_size_t(len(settings))))

    def test_huge_counts_are_errors(self):
        x, t = (ctypes.c_double * 9)(0, 0, 0, 1, 0, 0, 0, 1, 0), (ctypes.c_int32 * 3)(0, 1, 2)
        size = ctypes.c_size_t
        for huge in (2**64 - 1, 0x5555555555555556, 0x2000000000000000, 2**31):
            for nodes, triangles, settings in ((huge, 1, 0), (3, huge, 0), (3, 1, huge)):
                got = self.kt.kt_open_arrays(x, size(nodes), t, size(triangles), None, size(0), None, size(settings))
                self.assertFalse(got)
                self.assertNotIn("std::", self.error())
                self.assertIn(str(huge), self.error())

    def test_settings_do_not_speak_of_a_command_line(self):
        self.assertFalse(self.opened("contact.mu=-1").value)
        self.assertNotIn("--set", self.error())
        self.assertFalse(self.opened("contact.mo=1").value)
        self.assertNotIn("--set", self.error())

    def test_wrong_order_and_wrong_times_are_misuse(self):
        touch = self.opened("local.reducer=wall")
        self.assertTrue(touch.value, self.error())
        pose, frame, one = Pose(size=ctypes.sizeof(Pose), turn=(1, 0, 0, 0)), Frame(size=ctypes.sizeof(Frame)), ctypes.c_size_t(1)
        pose.x[:] = TOP
        self.assertEqual(self.kt.kt_start(touch), MISUSE)
        tick_after = lambda s: self.kt.kt_tick_after(touch, ctypes.byref(pose), one, ctypes.c_double(s), ctypes.byref(frame))
        self.assertEqual(self.kt.kt_place(touch, ctypes.byref(pose), one), 0)
        for wrong in (-1, math.nan, math.inf):
            self.assertEqual(tick_after(wrong), MISUSE)
        self.assertEqual(tick_after(1e308), 0)
        before = frame.t
        self.assertEqual(tick_after(0.005), 0)
        self.assertAlmostEqual(frame.t, before + 0.005, delta=0.0011)
        self.assertEqual(self.kt.kt_place(touch, ctypes.byref(pose), one), MISUSE)
        self.assertEqual(self.kt.kt_start(touch), MISUSE)
        self.kt.kt_close(touch)

    def test_a_tool_that_went_through_is_told(self):
        touch, one, needed = self.opened("local.reducer=wall"), ctypes.c_size_t(1), ctypes.c_size_t()
        pose, frame = Pose(size=ctypes.sizeof(Pose), turn=(1, 0, 0, 0)), Frame(size=ctypes.sizeof(Frame))
        told = ctypes.create_string_buffer(4000)
        pose.x[:] = [0.03, 0.026, 0.2]
        self.assertEqual(self.kt.kt_place(touch, ctypes.byref(pose), one), 0)
        for i in range(150):
            pose.x[2] = 0.2 if i < 50 else -0.2
            self.assertEqual(self.kt.kt_tick(touch, ctypes.byref(pose), one, ctypes.byref(frame)), 0)
        self.assertEqual(self.kt.kt_warnings(touch, told, ctypes.c_size_t(len(told)), ctypes.byref(needed)), 0)
        self.assertIn(THROUGH, told.value.decode())
        count, found = ctypes.c_size_t(), FoundOne(size=ctypes.sizeof(FoundOne))
        self.assertEqual(self.kt.kt_finding_at(touch, ctypes.c_size_t(0), None, ctypes.byref(count)), 0)
        self.assertEqual(count.value, len(told.value.decode().splitlines()))
        said = []
        for i in range(count.value):
            self.assertEqual(self.kt.kt_finding_at(touch, ctypes.c_size_t(i), ctypes.byref(found), ctypes.byref(count)), 0)
            said.append((found.weight, found.what.decode()))
        self.assertIn(2, [weight for weight, what in said if THROUGH in what])
        found.what = b"kept"
        self.assertEqual(self.kt.kt_finding_at(touch, count, ctypes.byref(found), ctypes.byref(count)), 0)
        self.assertEqual(found.what, b"kept", "beyond the last one")
        self.kt.kt_close(touch)


if __name__ == "__main__":
    unittest.main()
