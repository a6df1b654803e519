#!/usr/bin/python3
"""Whole runs from Python: the command's, to the bit; who ends them, and when Python itself ends."""
import gc
import os
import resource
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import numpy as np

import kilotouch as kt
from support import BLOCK, PATIENCE, PROGRAM, QUICK, TOP, press, script


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
        _, err = process.communicate(timeout=PATIENCE)
        self.assertIn("KeyboardInterrupt", err)

    def test_end_of_python_ends_a_run_that_was_started(self):
        process = script(f"import kilotouch as kt\ns = kt.Session(kt.Scene(settings={ {**QUICK, 'duration': 3000} }))\n"
                         "s.start()\nassert s.is_running")
        _, err = process.communicate(timeout=PATIENCE)
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
            _, err = process.communicate(timeout=PATIENCE)
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
        # The colours of the reports and of the live page: Okabe and Ito's blue and vermilion.
        self.assertEqual([line.get_color() for line in lines], ["#0072B2", "#D55E00"] * 2)


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
