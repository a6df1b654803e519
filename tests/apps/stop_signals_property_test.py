#!/usr/bin/python3
"""SIGTERM and the first Ctrl-C end every stage within two seconds: exit code 143 or 130, a word of what is kept, whole
files only, no children and no temporary files left. KILOTOUCH names the program; KT_LONG=1: each stage by every signal, not
by one of them, and at more moments while a matrix is ordered."""
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from patience import PATIENCE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
LIMIT = 2.0  # [s]
SLACK = 1.0  # [s] the test may share its machine
ORGAN = os.path.join(ROOT, "scenes", "organ_springs.json")
BODY = os.path.join(ROOT, "meshes", "organ.off")
LONG = os.environ.get("KT_LONG")
MOMENTS = [(signal.SIGTERM, 0.15), (signal.SIGINT, 0.8), (signal.SIGTERM, 3.0)]  # [s] after its start
AT_ONCE = ("tetgen", "netgen", "wrap", "stability", "chart", "paper")  # stages that have no other before them
FINE = ["--set", "object.tetrahedralize.max_volume=2e-9"]  # a body whose every stage takes long


def stages():
    """name -> words. Signals come at several times, so that each of its stages is met."""
    run = lambda *words: ["run", ORGAN, "--no-report", "--out", "o", *words]
    yield "ticks", run("--set", "duration=300", "--set", "local.reducer=condensed")
    yield "set-up, certificates, factorizations", run("--set", "duration=300", *FINE)
    yield "reference", run("--set", "duration=0.05", "--set", "local.reducer=wall", "--reference", "--reference-rate", "1000000")
    yield "self-contact", run("--set", "duration=300", "--set", "global.self_contact={}", "--set", "global.integrator=newton_euler", "--set", "local.reducer=wall")
    yield "two threads", run("--set", "duration=300", "--set", "link.type=thread", "--set", "local.reducer=wall")
    for backend in ("tetgen", "netgen", "cgal"):
        yield backend, ["mesh", "tet", BODY, "--backend", backend, "--max-volume", "1e-10", "-o", "o.vtu"]
    yield "wrap", ["mesh", "repair", BODY, "--wrap", "--alpha", "2e-4", "-o", "o.off"]
    yield "check", ["check", os.path.join(ROOT, "meshes"), "--jobs", "2", "--out", "o"]
    yield "stability", ["stability", "time_step", "--full", "--out", "o"]
    yield "advise", ["advise", ORGAN, "--budget-seconds", "600"]
    yield "chart", ["chart", "--out", "o"]
    yield "paper", ["paper", "--out", "o", "--set", "duration=100"]


def waited_for_processor(pid):
    """Seconds that the main thread waited while others had the processor."""
    try:
        with open(f"/proc/{pid}/schedstat", encoding="utf-8") as file:
            return 1e-9 * float(file.read().split()[1])
    except (OSError, IndexError):
        return 0.0


def has_begun(pid):
    """Main has blocked SIGTERM: before, while libraries are loaded, the system ends the process."""
    try:
        with open(f"/proc/{pid}/status", encoding="utf-8") as file:
            blocked = next(line for line in file if line.startswith("SigBlk:"))
        return int(blocked.split()[1], 16) >> (signal.SIGTERM - 1) & 1 == 1
    except (OSError, StopIteration):
        return False


class StopSignals(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name
        self.scratch = os.path.join(self.folder, "tmp")
        self.work = os.path.join(self.folder, "work")
        os.mkdir(self.scratch)
        os.mkdir(self.work)

    def stopped(self, words, number, after):
        """Seconds that it took, exit code, words on stderr. `after`: seconds, or what must be true first."""
        process = subprocess.Popen([PROGRAM, *words], cwd=self.work, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
                                   env=dict(os.environ, TMPDIR=self.scratch))
        self.addCleanup(process.kill)
        while not has_begun(process.pid) and process.poll() is None:
            time.sleep(0.005)
        if callable(after):
            while not after() and process.poll() is None:
                time.sleep(0.01)
        else:
            time.sleep(after)
        if process.poll() is not None:
            process.communicate()
            return None
        start, waited = time.monotonic(), waited_for_processor(process.pid)
        process.send_signal(number)
        # The time in which other programs had the processor is not this one's.
        lost = 0.0
        while process.poll() is None and time.monotonic() - start < PATIENCE:
            lost = max(lost, waited_for_processor(process.pid) - waited)
            time.sleep(0.02)
        seconds = time.monotonic() - start - lost
        _, error = process.communicate(timeout=PATIENCE)
        return seconds, process.returncode, error

    def nothing_is_left(self):
        time.sleep(0.2)
        self.assertEqual(subprocess.run(["pgrep", "-f", self.folder], capture_output=True, text=True).stdout.split(), [], "children live on")
        self.assertEqual(os.listdir(self.scratch), [])
        for folder, _, files in os.walk(self.work):
            for name in files:
                self.assertFalse(name.startswith(".kilotouch-"), name)
                if name.endswith((".json", ".html")) and os.path.getsize(os.path.join(folder, name)) > 0:
                    with open(os.path.join(folder, name), encoding="utf-8") as file:
                        text = file.read()
                    self.assertTrue(text.rstrip().endswith(("}", "]", "</html>")), name)

    def test_every_stage_ends_in_time(self):
        for name, words in stages():
            if os.environ.get("STAGE", name) != name:
                continue
            for number, after in MOMENTS if LONG else [MOMENTS[name not in AT_ONCE]]:
                with self.subTest(f"{name}, {after} s"):
                    for folder in (self.work, self.scratch):
                        shutil.rmtree(folder)
                        os.mkdir(folder)
                    found = self.stopped(words, number, after)
                    if found is None:
                        self.assertGreater(after, 0.5, "refused, or over at once")
                        continue  # it was done before
                    seconds, code, error = found
                    if "what was recorded" not in error:  # for that a long refresh is waited for
                        self.assertLess(seconds, LIMIT + SLACK)
                    self.assertEqual(code, 128 + number, error)
                    if os.environ.get("VERBOSE"):
                        print(f"{name}, {signal.Signals(number).name} after {after} s: {seconds:.2f} s, {error.strip().splitlines()[-1][:60]}", flush=True)
                    self.assertRegex(error, "SIGTERM|SIGINT")
                    self.nothing_is_left()

    def test_what_was_recorded_is_kept(self):
        out = os.path.join(self.work, "o")
        words = ["run", ORGAN, "--set", "duration=300", "--set", "local.reducer=condensed", "--out", "o"]
        for wait in (1, 5, 20, 60):  # [s] on a busy machine it may still prepare its first model
            seconds, code, error = self.stopped(words, signal.SIGTERM, lambda: os.path.isdir(out) and time.sleep(wait) is None)
            if os.path.exists(os.path.join(out, "summary.json")):
                break
        self.assertEqual(code, 143)
        with open(os.path.join(out, "summary.json"), encoding="utf-8") as file:
            summary = json.load(file)
        self.assertTrue(any("stopped early" in warning for warning in summary["warnings"]))
        with open(os.path.join(out, "trace.csv"), encoding="utf-8") as file:
            self.assertEqual(len(file.readlines()) - 1, summary["ticks"]["total"])
        replay = subprocess.run([PROGRAM, "replay", "o"], cwd=self.work, capture_output=True, text=True)
        self.assertIn("bit for bit", replay.stdout, replay.stderr)  # as long as it was, not as the scene would be
        self.nothing_is_left()

    def test_a_run_without_an_end_lasts_until_it_is_stopped(self):
        out = os.path.join(self.work, "o")
        pad = os.path.join(ROOT, "scenes", "slab_drag.json")
        words = ["run", pad, "--set", "duration=null", "--set", "link.type=thread", "--set", "local.reducer=wall", "--no-report", "--out", "o"]
        for wait in (1.5, 5, 20, 60):  # [s] on a busy machine it may still prepare its first model
            seconds, code, error = self.stopped(words, signal.SIGINT, lambda: os.path.isdir(out) and time.sleep(wait) is None)
            self.assertLess(seconds, LIMIT + SLACK)
            self.assertEqual(code, 130)
            if not os.path.exists(os.path.join(out, "session.json")):
                continue
            with open(os.path.join(out, "session.json"), encoding="utf-8") as file:
                session = json.load(file)
            with open(os.path.join(out, "trace.csv"), encoding="utf-8") as file:
                ticks = len(file.readlines()) - 1
            if ticks > 100:
                break
            shutil.rmtree(out)
        self.assertAlmostEqual(session["scene"]["duration"] * 1000, ticks, places=6)
        self.assertGreater(ticks, 100)
        replay = subprocess.run([PROGRAM, "replay", "o"], cwd=self.work, capture_output=True, text=True)
        self.assertIn("bit for bit", replay.stdout, replay.stderr)  # its code is the run's: 1 where models came late
        self.nothing_is_left()

    def test_no_stop_is_lost_while_a_matrix_is_ordered(self):
        """METIS, below CHOLMOD, sets a handler of its own for SIGTERM while it orders: that one must not get the signal."""
        words = ["run", ORGAN, "--no-report", "--out", "o", "--set", "duration=300", "--set", "local.reducer=full", *FINE]
        for k in range(6) if LONG else (1, 4):
            found = self.stopped(words, signal.SIGTERM, 0.3 + 0.35 * k)
            self.assertIsNotNone(found)
            self.assertLess(found[0], LIMIT + SLACK)
            self.assertEqual(found[1], 143, found[2])

    def test_a_second_signal_ends_at_once(self):
        process = subprocess.Popen([PROGRAM, "run", ORGAN, "--no-report", "--out", "o", "--set", "duration=300", *FINE], cwd=self.work, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        while not has_begun(process.pid):
            time.sleep(0.005)
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, error = process.communicate(timeout=PATIENCE)
        self.assertIn("second signal", error)
        self.assertEqual(process.returncode, 130)


if __name__ == "__main__":
    unittest.main()
