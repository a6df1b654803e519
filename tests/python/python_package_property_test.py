#!/usr/bin/python3
"""The Python package against the command, the C library and physics written down anew in numpy.
PYTHONPATH has the package, KILOTOUCH names the program, KT_LIBRARY the C library."""
import ast
import ctypes
import gc
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import kilotouch as kt

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
LIBRARY = os.environ.get("KT_LIBRARY", os.path.join(ROOT, "build", "release", "libkilotouch.so"))
BLOCK = os.path.join(ROOT, "meshes", "block.msh")
ORGAN = os.path.join(ROOT, "scenes", "organ_drag.json")
QUICK = {"object.mesh": BLOCK, "local.reducer": "wall", "collision.backend": "brute_force", "duration": 0.3,
         "tool.path.press_drag.press_time": 0.1, "tool.path.press_drag.depth": 0.003}
TOP = np.array([0.03, 0.026, 0.03])


def press(depth, ticks, top=TOP):
    """A straight way down: (ticks + 1, 3)."""
    way = np.repeat(top[None], ticks + 1, 0)
    way[:, 2] -= np.linspace(0, depth, ticks + 1)
    return way


def script(text, **kwargs):
    return subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **kwargs)


class Runs(unittest.TestCase):
    def test_run_is_that_of_the_command_and_replays(self):
        trace = kt.Session(kt.Scene(settings=QUICK)).run()
        with tempfile.TemporaryDirectory() as folder:
            out = os.path.join(folder, "command")
            sets = [word for key, value in QUICK.items() if key != "object.mesh" for word in ("--set", f"{key}={value}")]
            scene = os.path.join(folder, "scene.json")
            with open(scene, "w") as file:
                file.write('{"object": {"mesh": "%s"}}' % BLOCK)
            subprocess.run([PROGRAM, "run", scene, *sets, "--no-report", "--out", out], check=True, capture_output=True)
            with open(os.path.join(out, "summary.json")) as file:
                self.assertIn(trace.hash, file.read())
            saved = os.path.join(folder, "saved")
            trace.save(saved)
            replay = subprocess.run([PROGRAM, "replay", saved], capture_output=True, text=True)
            self.assertEqual(replay.returncode, 0, replay.stderr)
            self.assertIn(trace.hash, replay.stdout)
            table = np.genfromtxt(os.path.join(saved, "trace.csv"), delimiter=",", names=True, usecols=(0, 4, 5, 6))
            np.testing.assert_array_equal(table["force_z"], trace.force[:, 2])
        self.assertEqual(trace.summary["hash"], trace.hash)
        self.assertGreater(trace.f_n.max(), 0.01)

    def test_path_is_followed_row_by_row(self):
        session = kt.Session(kt.Scene(settings=QUICK))
        path = press(0.008, 200)
        trace = session.run(path)
        np.testing.assert_allclose(trace.x, path[1:], atol=1e-15)
        self.assertEqual(len(trace), 200)
        np.testing.assert_allclose(trace.t, 1e-3 * np.arange(1, 201), rtol=1e-12)
        again = session.run(path)
        self.assertEqual(again.hash, trace.hash)
        with self.assertRaisesRegex(kt.InputError, "run again since"):
            trace.save("/nowhere")
        own = session.run()
        self.assertEqual(own.hash, kt.Session(kt.Scene(settings=QUICK)).run().hash)  # its own path is not forgotten
        for wrong, words in ((path[:1], "n >= 2"), (path[:, :2], "n >= 2"), (path * np.nan, r"path\[0\]"), (path + 1e7, "not within"),
                             (path.astype(str), "numbers are needed")):
            with self.assertRaisesRegex(kt.InputError, words):
                session.run(wrong)
        self.assertEqual(session.run().hash, own.hash)

    def test_columns_are_views_that_outlive_the_run(self):
        force = kt.Session(kt.Scene(settings=QUICK)).run().force
        self.assertFalse(force.flags.writeable)
        self.assertIsNotNone(force.base)
        sum_before = force.sum()
        gc.collect()
        kt.Session(kt.Scene(settings=QUICK)).run()
        self.assertEqual(force.sum(), sum_before)

    def test_control_c_ends_a_run(self):
        process = script(f"import kilotouch as kt\ns = kt.Session(kt.Scene(settings={ {**QUICK, 'duration': 3000} }))\n"
                         "print('runs', flush=True)\ns.run()")
        self.assertEqual(process.stdout.readline(), "runs\n")
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=30)
        self.assertIn("KeyboardInterrupt", err)

    def test_end_of_python_ends_a_run_that_was_started(self):
        process = script(f"import kilotouch as kt\ns = kt.Session(kt.Scene(settings={ {**QUICK, 'duration': 3000} }))\n"
                         "s.start()\nassert s.is_running")
        _, err = process.communicate(timeout=60)
        self.assertEqual((process.returncode, err), (0, ""))

    def test_a_run_has_one_trace_whoever_ends_it(self):
        session = kt.Session(kt.Scene(settings={**QUICK, "duration": 3000}))
        session.start()
        with self.assertRaisesRegex(kt.InputError, "runs already"):
            session.start()
        outcomes = []

        def stop():
            try:
                outcomes.append(session.stop())
            except (kt.RunError, kt.InputError) as error:
                outcomes.append(error)

        threads = [threading.Thread(target=stop) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sum(isinstance(o, kt.Trace) for o in outcomes), 1, outcomes)
        self.assertFalse(session.is_running)

    def test_end_of_python_in_the_middle_of_whatever_runs(self):
        begin = f"import kilotouch as kt, threading, time\nscene = kt.Scene(settings={ {**QUICK, 'duration': 3000} })\n"
        for text in ("t = kt.Touch(scene)\ndef loop():\n    while True: t.tick([0.03, 0.026, 0.028])\n"
                     "threading.Thread(target=loop, daemon=True).start()\ntime.sleep(0.3)",
                     "s = kt.Session(scene)\nthreading.Thread(target=s.run, daemon=True).start()\ntime.sleep(0.3)",
                     "t = kt.Touch(scene)\nt.place([0.03, 0.026, 0.028])\nt.start()\nt.tick([0.03, 0.026, 0.028])"):
            process = script(begin + text)
            _, err = process.communicate(timeout=60)
            self.assertEqual((process.returncode, err), (0, ""), text)

    def test_what_is_in_memory_only_is_not_said_to_be_replayed(self):
        mesh = kt.load_mesh(BLOCK)
        trace = kt.Session(kt.Scene(settings=QUICK), mesh=mesh).run()
        with tempfile.TemporaryDirectory() as folder:
            trace.save(folder)
            self.assertTrue(os.path.exists(os.path.join(folder, "trace.csv")))
            self.assertFalse(os.path.exists(os.path.join(folder, "session.json")))

    def test_a_picture_is_drawn(self):
        try:
            import matplotlib
        except ImportError:
            self.skipTest("no matplotlib")
        matplotlib.use("Agg")
        trace = kt.Session(kt.Scene(settings=QUICK)).run()
        lines = kt.plot(trace, trace).axes[0].get_lines()
        np.testing.assert_array_equal(lines[0].get_ydata(), trace.f_n)


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
        for x in press(0.008, 300):
            frame = touch.tick(x)
            time.sleep(1e-3)
        touch.stop()
        self.assertGreater(frame.f_n, 0.01)
        self.assertGreater(touch.status.refreshes, 3)
        moved = np.linalg.norm(touch.positions - touch.mesh.x, axis=1)
        self.assertGreater(moved.max(), 1e-3)

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


class Devices(unittest.TestCase):
    HELD = {**QUICK, "duration": 60, "tool.path.device.name": "pushed", "tool.path.device.max_force": 0.1,
            "tool.path.device.deadman": 1, "tool.path.device.origin": [0, 0, 0]}

    def test_tick_device_is_made_safe(self):
        touch = kt.Touch(kt.Scene(settings={k: v for k, v in self.HELD.items() if "press_drag" not in k}))
        most, before, zero_after = 0, np.zeros(3), None
        x = TOP.copy()
        touch.place(x)
        for i in range(1500):
            if i < 1200:
                x[2] = 0.03 - 0.008 * min(1, i / 800)
            age = 0 if i < 1200 else 1e-3 * (i - 1199)
            force = touch.tick_device(kt.DeviceReading(x, age=age, buttons=1)).force
            most = max(most, np.linalg.norm(force))
            if i < 1200:
                self.assertLessEqual(np.linalg.norm(force - before), 0.2 + 1e-12, i)  # 200 N/s
            if i >= 1200 and zero_after is None and not force.any():
                zero_after = age
            before = force
        self.assertAlmostEqual(most, 0.1, delta=1e-9)
        self.assertLessEqual(zero_after, 0.0201)
        with self.assertRaisesRegex(kt.InputError, 'did you mean "fault"'):
            kt.DeviceReading(x, health="fualt")

    def test_pushed_device_gets_what_is_safe_and_nothing_when_it_is_silent(self):
        device = kt.PushedDevice()
        session = kt.Session(kt.Scene(settings={k: v for k, v in self.HELD.items() if "press_drag" not in k}))
        device.push(TOP, buttons=1)
        session.start(pushed=device)
        most, felt = 0, 0
        begun = time.monotonic()
        while (t := time.monotonic() - begun) < 1.6 or (felt <= 0.02 and t < 20):  # on a busy machine the gate shuts now and then
            x = TOP - [0, 0, 0.008 * min(1, t / 1.2)]
            device.push(x, buttons=1)
            force, torque = device.order
            most = max(most, np.linalg.norm(force))
            felt = max(felt, force[2])
            self.assertTrue(np.isfinite([*force, *torque]).all())
            time.sleep(0.5e-3)
        time.sleep(0.06)  # no pose, for longer than 20 ms whatever the machine does
        force, _ = device.order
        self.assertEqual(np.linalg.norm(force), 0)
        trace = session.stop()
        self.assertGreater(felt, 0.02)
        self.assertLessEqual(most, 0.1 + 1e-12)
        self.assertEqual(np.linalg.norm(device.order[0]), 0)  # the tick has stopped
        self.assertGreater(len(trace), 1000)
        self.assertTrue((trace.flags & kt.Flag.STALE_POSE).any())

    def test_a_device_is_of_one_session(self):
        settings = {k: v for k, v in self.HELD.items() if "press_drag" not in k}
        device = kt.PushedDevice()
        device.push(TOP, buttons=1)
        first, second = (kt.Session(kt.Scene(settings=settings)) for _ in range(2))
        first.start(pushed=device)
        with self.assertRaisesRegex(kt.InputError, "another session"):
            second.start(pushed=device)
        first.stop()
        device.push(TOP, buttons=1)
        second.start(pushed=device)
        second.stop()
        with self.assertRaisesRegex(kt.InputError, "is not pushed"):
            kt.Session(kt.Scene(settings=QUICK)).run(pushed=device)

    def test_wrong_readings_are_told(self):
        device = kt.PushedDevice()
        for pose, words in (([*TOP, 5, 0, 0, 0], "length 5"), ([1e30, 0, 0], "beyond"), (["1", "2", "3"], "numbers are needed")):
            with self.assertRaisesRegex(kt.InputError, words):
                device.push(pose)
            with self.assertRaisesRegex(kt.InputError, words):
                kt.DeviceReading(pose)
        with self.assertRaisesRegex(kt.InputError, "age: -5"):
            kt.DeviceReading(TOP, age=-5)
        with self.assertRaisesRegex(kt.InputError, "v: 3 numbers"):
            device.push(TOP, v=[1, 2])

    def test_pushed_device_without_poses_is_told(self):
        settings = {k: v for k, v in self.HELD.items() if "press_drag" not in k}
        with self.assertRaisesRegex(kt.InputError, "nobody pushes"):
            kt.Session(kt.Scene(settings=settings)).run()
        with self.assertRaisesRegex(kt.InputError, "no pose for 2 s"):
            kt.Session(kt.Scene(settings=settings)).run(pushed=kt.PushedDevice())
        device = kt.PushedDevice()
        with self.assertRaisesRegex(kt.InputError, "not finite; nothing was taken"):
            device.push([0, math.nan, 0])


class Linear(kt.Model):
    """Linear elasticity on tetrahedra with lumped mass, from its definition: K = V B' C B, D = 5 M + 2e-3 K."""

    YOUNG, POISSON, DENSITY = 1e4, 0.3, 1000.0

    def __init__(self, mesh):
        import scipy.sparse
        x, tets = mesh.x, mesh.tetrahedra
        lam = self.YOUNG * self.POISSON / ((1 + self.POISSON) * (1 - 2 * self.POISSON))
        mu = self.YOUNG / (2 * (1 + self.POISSON))
        edges = x[tets[:, 1:]] - x[tets[:, :1]]  # (n, 3, 3), a row an edge
        volume = np.linalg.det(edges) / 6
        mass = np.bincount(tets.ravel(), np.repeat(self.DENSITY * volume / 4, 4), len(x))
        inverse = np.linalg.inv(edges)
        g = np.concatenate([-inverse.sum(2)[:, :, None], inverse], 2)  # gradients of the shape functions (n, 3, 4)
        k = np.einsum("n,nia,njb->naibj", volume * lam, g, g) + np.einsum("n,nja,nib->naibj", volume * mu, g, g)
        k += np.einsum("n,nla,nlb,ij->naibj", volume * mu, g, g, np.eye(3))
        dofs = (3 * tets[:, :, None] + np.arange(3)).reshape(-1, 12)
        rows, columns, values = np.repeat(dofs, 12, 1).ravel(), np.tile(dofs, 12).ravel(), k.ravel()
        low = x[:, 2] <= x[:, 2].min() + 0.05 * np.ptp(x[:, 2])
        super().__init__(mesh, mass, np.flatnonzero(low))
        self.k = scipy.sparse.csc_matrix((values, (rows, columns)), shape=self.mass.shape)
        self.d = 5.0 * self.mass + 2e-3 * self.k

    def force(self, x, v):
        return -(self.k @ (x - self.mesh.x).ravel()) - self.d @ v.ravel()

    def tangent(self, x, v, definite):
        return -self.k, -self.d


class Models(unittest.TestCase):
    SCENE = {**QUICK, "object.model.type": "fem", "object.model.material": "linear", "object.model.young": Linear.YOUNG,
             "object.model.poisson": Linear.POISSON, "object.model.damping.mass": 5, "object.model.damping.stiffness": 2e-3,
             "object.model.damping.law": "rayleigh", "global.tolerance": 1e-12}

    def setUp(self):
        try:
            import scipy.sparse  # noqa: F401
        except ImportError:
            self.skipTest("no scipy")

    def test_python_physics_gives_the_forces_of_the_same_in_c(self):
        mesh = kt.load_mesh(BLOCK)
        path = press(0.008, 200)
        theirs = kt.Session(kt.Scene(settings=self.SCENE)).run(path)
        ours = kt.Session(kt.Scene(settings={**QUICK, "global.tolerance": 1e-12}), model=Linear(mesh)).run(path)
        self.assertGreater(theirs.f_n[-1], 0.05)
        np.testing.assert_allclose(ours.force, theirs.force, atol=1e-9 * theirs.f_n.max())

    def test_tangent_by_differences_gives_the_same_forces(self):
        class Slow(Linear):
            tangent = None

        mesh = kt.load_mesh(BLOCK)
        path = press(0.006, 100)
        with_tangent, without = (kt.Session(kt.Scene(settings=QUICK), model=m(mesh)).run(path) for m in (Linear, Slow))
        np.testing.assert_allclose(without.force, with_tangent.force, atol=1e-6 * with_tangent.f_n.max())

    def test_check_tells_a_wrong_tangent(self):
        mesh = kt.load_mesh(BLOCK)
        passed, text = kt.check_model(Linear(mesh))
        self.assertTrue(passed, text)

        class Wrong(Linear):
            def tangent(self, x, v, definite):
                return -1.01 * self.k, -self.d

        passed, text = kt.check_model(Wrong(mesh))
        self.assertFalse(passed)
        self.assertIn("WRONG", text)

    def test_what_a_model_raises_ends_the_run_with_its_words(self):
        class Breaks(Linear):
            calls = 0

            def force(self, x, v):
                Breaks.calls += 1
                if Breaks.calls > 20:
                    raise ZeroDivisionError("the foam has burnt")
                return super().force(x, v)

        with self.assertRaisesRegex(kt.RunError, "model.force: ZeroDivisionError: the foam has burnt"):
            kt.Session(kt.Scene(settings=QUICK), model=Breaks(kt.load_mesh(BLOCK))).run()
        Breaks.calls = 0
        touch = kt.Touch(kt.Scene(settings=QUICK), model=Breaks(kt.load_mesh(BLOCK)))
        with self.assertRaisesRegex(kt.RunError, "the foam has burnt"):
            for x in press(0.008, 3000):
                touch.tick(x)

    def test_the_collector_may_come_in_the_middle_of_the_physics(self):
        class Forgotten(Linear):
            def force(self, x, v):
                gc.collect()
                return super().force(x, v)

        mesh = kt.load_mesh(BLOCK)
        for make in (kt.Session, kt.Touch):
            model = Forgotten(mesh)
            held = make(kt.Scene(settings={**QUICK, "duration": 0.2}), model=model)
            model.holds = [model, held]  # a cycle
            if make is kt.Touch:
                held.place(TOP)
            held.start()
            del held, model
            time.sleep(0.3)
            gc.collect()

    def test_a_model_does_not_wait_for_itself(self):
        class Impatient(Linear):
            def force(self, x, v):
                self.session.stop()

        model = Impatient(kt.load_mesh(BLOCK))
        model.session = kt.Session(kt.Scene(settings=QUICK), model=Linear(model.mesh))
        with self.assertRaisesRegex(kt.RunError, "model's own functions"):
            kt.Session(kt.Scene(settings=QUICK), model=model).run()

    def test_settings_that_do_nothing_are_told(self):
        trace = kt.Session(kt.Scene(settings={**QUICK, "object.model.young": 5e5}), model=Linear(kt.load_mesh(BLOCK))).run()
        self.assertIn("a model of one's own", " ".join(trace.warnings))

    def test_what_is_no_model_is_told(self):
        mesh = kt.load_mesh(BLOCK)
        scene = kt.Scene(settings=QUICK)
        n = len(mesh.x)

        class Short(Linear):
            def force(self, x, v):
                return np.zeros(3)

        import scipy.sparse
        torn = scipy.sparse.identity(3 * n, format="csc")
        torn.indices[5] = 10 * n
        for model, words in ((kt.Model(mesh, np.ones(n - 1)), "mass: .* must be"), (kt.Model(mesh, np.ones(n), [n]), "fixed: node"),
                             (object(), "model: has no mesh"), (kt.Model(mesh, np.ones(n), np.arange(n)), "all nodes are clamped"),
                             (kt.Model(mesh, np.zeros(n)), "mass: 0"), (kt.Model(mesh, np.full(n, np.nan)), "mass: a number"),
                             (kt.Model(mesh, torn), "out of range")):
            with self.assertRaisesRegex(kt.InputError, words):
                kt.Touch(scene, model=model)
        self.assertEqual(kt.Model(mesh, np.ones(n), mesh.x[:, 2] < 1e-6).fixed, list(np.flatnonzero(mesh.x[:, 2] < 1e-6)))
        for fixed in ([0.5, 1.5], [[0, 1]], np.ones(n - 1, bool)):
            with self.assertRaisesRegex(kt.InputError, "fixed"):
                kt.Model(mesh, np.ones(n), fixed)
        class Turned(Linear):
            def force(self, x, v):
                return np.zeros((3, len(x)))

        for wrong in (Short, Turned):
            with self.assertRaisesRegex(kt.RunError, f"must give {3 * n} numbers"):
                kt.Session(scene, model=wrong(mesh)).run()
        with self.assertRaisesRegex(kt.InputError, "give one"):
            kt.Touch(scene, mesh=mesh, model=Linear(mesh))


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
                                 ((x + np.inf, [[0, 1, 2]]), r"x\[0\]"), ((x,), "triangles: a mesh has one")):
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


class Memory(unittest.TestCase):
    def test_sessions_that_are_dropped_leave_nothing(self):
        settings = {**QUICK, "duration": 0.01, "tool.path.press_drag.press_time": 0.005}

        def some(count):
            for _ in range(count):
                kt.Session(kt.Scene(settings=settings)).run()
                kt.Touch(kt.Scene(settings=settings)).tick(TOP)

        some(8)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        some(30)
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, 8000)  # kB


if __name__ == "__main__":
    unittest.main()
