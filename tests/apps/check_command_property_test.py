#!/usr/bin/python3
"""kilotouch check over small libraries: verdicts, kills and resumption, parts and their merge, baselines, the page.
KILOTOUCH names the program; KT_LONG=1: more broken files, more kills."""
import importlib.machinery
import importlib.util
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from patience import PATIENCE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
sys.path.insert(0, os.path.join(ROOT, "scripts"))  # what scripts share
loader = importlib.machinery.SourceFileLoader("mesh_variants", os.path.join(ROOT, "scripts", "mesh_variants"))
variants = importlib.util.module_from_spec(importlib.util.spec_from_loader("mesh_variants", loader))
loader.exec_module(variants)
import mesh_shapes  # noqa: E402
LONG = os.environ.get("KT_LONG")
STAGES = ["load", "doctor", "repair", "queries", "shots", "solid", "models", "local_models", "press", "drag", "energy"]


def check(*arguments, ok=(0, 1), wait=PATIENCE):
    """Exit code and output."""
    result = subprocess.run([PROGRAM, "check", *map(str, arguments)], capture_output=True, text=True, timeout=wait)
    assert result.returncode in ok, f"{result.returncode}\n{result.stdout}\n{result.stderr}"
    return result.returncode, result.stdout + result.stderr


def report(folder):
    with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
        return json.load(file)


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(inner) for key, inner in value.items() if key != "times"}
    return [without_times(inner) for inner in value] if isinstance(value, list) else value


def lines(file):
    with open(file, encoding="utf-8") as opened:
        return [line for line in opened if line.endswith("\n")]


SURFACES = ("--until", "solid")  # for tests of the batch, not of the contact: a tenth of the time
FILLED = (*SURFACES, "--body", "mesh")  # by programs of others


class Check(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def write(self, name, data):
        os.makedirs(os.path.dirname(self.path("library", name)), exist_ok=True)
        with open(self.path("library", name), "wb") as file:
            file.write(data)

    def small_library(self):
        """Seven files: three that can be touched, four with faults."""
        sphere, box = mesh_shapes.icosphere(1), mesh_shapes.box(4, 3, 2)
        self.write("ball.off", mesh_shapes.write_off(*sphere))
        self.write("deep/box.obj", mesh_shapes.write_obj(*box))
        self.write("deep/turned.stl", mesh_shapes.write_stl_binary(box[0], [f[::-1] for f in box[1]]))
        self.write("open.ply", mesh_shapes.write_ply(sphere[0], sphere[1][4:]))
        self.write("empty.off", b"")
        self.write("cut.off", mesh_shapes.write_off(*sphere)[:900])
        self.write("nan.obj", b"v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n")
        return self.path("library")

    def rows(self, folder):
        return {row["path"]: row for row in report(folder)["rows"]}

    def test_each_mesh_gets_its_verdict_and_its_reason(self):
        code, text = check(self.small_library(), "--quick", "--jobs", 2, "--out", self.path("out"))
        rows = self.rows(self.path("out"))
        self.assertEqual(list(rows), sorted(["ball.off", "deep/box.obj", "deep/turned.stl", "open.ply", "empty.off", "cut.off", "nan.obj"]))
        self.assertEqual(code, 1, text)  # three files fail and there is no baseline
        for name in ("ball.off", "deep/box.obj", "deep/turned.stl"):
            self.assertIn(rows[name]["verdict"], ("pass", "degraded"), rows[name]["why"])
            self.assertEqual([s["name"] for s in rows[name]["stages"]], STAGES)
            self.assertNotIn("fail", [s["verdict"] for s in rows[name]["stages"]])
            figures = {s["name"]: s["figures"] for s in rows[name]["stages"]}
            self.assertEqual(figures["shots"]["leaks"], 0)
            self.assertGreater(figures["shots"]["through"], 50)
            self.assertGreater(figures["queries"]["rays_that_hit"], 20)
            self.assertGreater(figures["press"]["fem"]["largest_force"], 0)
            self.assertGreater(figures["models"]["fem"]["stable_step"], 0)
            self.assertNotIn("msd", figures["models"])  # a surface that is run is of elements
            self.assertGreater(figures["solid"]["lattice"]["edge"], 0)
            self.assertLess(abs(figures["solid"]["nodes"] - 300), 150)
        doctor = lambda name: next(s for s in rows[name]["stages"] if s["name"] == "doctor")
        self.assertIn("inside out", doctor("deep/turned.stl")["why"])
        self.assertEqual(rows["open.ply"]["verdict"], "degraded", rows["open.ply"]["why"])
        self.assertIn("open edges", doctor("open.ply")["why"])
        self.assertEqual(len(doctor("open.ply")["where"]), 3)
        for name, reason in (("empty.off", "refused: empty.off: file is empty"), ("cut.off", "refused: cut.off:.* ends"), ("nan.obj", "refused: nan.obj:3: .*nan")):
            self.assertEqual((rows[name]["verdict"], rows[name]["stage"]), ("fail", "load"))
            self.assertRegex(rows[name]["why"], reason)
        with open(self.path("out", "report.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertIn("deep/turned.stl", page)
        self.assertNotRegex(page, r"(src|href)=.?https?://")  # needs nothing else
        self.assertNotIn(self.folder, page)

    def test_a_surface_that_is_filled_is_of_springs_and_of_elements(self):
        self.write("box.obj", mesh_shapes.write_obj(*mesh_shapes.box(4, 3, 2)))
        check(self.path("library"), "--quick", "--body", "mesh", "--until", "models", "--out", self.path("out"), "--no-report")
        figures = {s["name"]: s["figures"] for s in self.rows(self.path("out"))["box.obj"]["stages"]}
        self.assertNotIn("lattice", figures["solid"])
        for model in ("msd", "fem"):
            self.assertGreater(figures["models"][model]["stable_step"], 0)

    def test_a_cube_whose_corners_are_its_only_nodes_passes(self):
        # A motion of a whole wave a side moves all corners alike, and there is no force to compare with the tangent.
        self.write("cube.off", mesh_shapes.write_off(*mesh_shapes.box(1, 1, 1)))
        check(self.path("library"), "--quick", "--body", "mesh", "--out", self.path("out"), "--no-report")
        energy = next(s for s in report(self.path("out"))["rows"][0]["stages"] if s["name"] == "energy")
        self.assertEqual(energy["verdict"], "pass", energy["why"])

    def test_the_same_library_gives_the_same_report_in_parts_and_out_of_them(self):
        library = self.small_library()
        check(library, *SURFACES, "--out", self.path("whole"), "--no-report")
        for part in ("1/3", "2/3", "3/3"):
            check(library, *SURFACES, "--out", self.path("parts"), "--shard", part)
        sizes = [len(lines(self.path("parts", f"rows-{i}-of-3.jsonl"))) for i in (1, 2, 3)]
        self.assertEqual(sum(sizes), 7)
        self.assertLessEqual(max(sizes) - min(sizes), 1)
        check("merge", self.path("parts"), "--out", self.path("merged"), "--no-report")
        self.assertEqual(without_times(report(self.path("merged"))), without_times(report(self.path("whole"))))
        self.assertNotEqual(report(self.path("merged")), report(self.path("whole")))  # the times are there, and differ

    def test_killed_at_random_and_resumed_it_loses_and_repeats_nothing(self):
        library = self.small_library()
        for i in range(12 if LONG else 6):  # enough work to be killed in
            shutil.copy(os.path.join(library, "ball.off"), os.path.join(library, f"ball{i}.off"))
        check(library, *SURFACES, "--out", self.path("whole"), "--no-report")
        r, rows, before, parents = random.Random(1), self.path("killed", "rows.jsonl"), [], 0
        for _ in range(60 if LONG else 20):
            run = subprocess.Popen([PROGRAM, "check", library, *SURFACES, "--jobs", "2", "--out", self.path("killed"), "--resume", "--no-report"],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
            try:
                run.wait(r.uniform(0.05, 0.6))
            except subprocess.TimeoutExpired:
                children = subprocess.run(["pgrep", "-P", str(run.pid)], capture_output=True, text=True).stdout.split()
                if children and r.random() < 0.5:  # a worker, and it goes on
                    try:
                        os.kill(int(r.choice(children)), signal.SIGKILL)
                    except ProcessLookupError:
                        pass
                    time.sleep(r.uniform(0.02, 0.2))
                run.kill()
                run.wait()
                parents += 1
            now = lines(rows) if os.path.exists(rows) else []
            done = [line for line in before if "(Killed)" not in line]
            self.assertEqual([line for line in done if line not in now], [], "a finished row was lost or made again")
            before = now
            if run.returncode >= 0:
                break
        self.assertGreater(parents, 1)
        check(library, *SURFACES, "--out", self.path("killed"), "--resume", "--no-report")
        self.assertEqual(without_times(report(self.path("killed"))), without_times(report(self.path("whole"))))
        time.sleep(0.3)
        left = subprocess.run(["pgrep", "-f", self.folder], capture_output=True, text=True).stdout.split()
        self.assertEqual(left, [], "workers outlived their parent")
        self.assertEqual([name for name in os.listdir(self.path("killed")) if ".work-" in name], [])

    def test_a_library_killed_from_outside_is_not_its_failure(self):
        if not shutil.which("tetgen"):
            self.skipTest("needs tetgen")
        library = self.small_library()
        check(library, *FILLED, "--out", self.path("whole"), "--no-report")
        os.mkdir(self.path("bin"))
        with open(self.path("bin", "tetgen"), "w", encoding="utf-8") as fake:
            fake.write(f"#!/bin/sh\necho . >>{self.path('tries')}\nkill -9 $$\n")
        os.chmod(self.path("bin", "tetgen"), 0o700)
        path = os.environ["PATH"]
        self.addCleanup(os.environ.__setitem__, "PATH", path)
        os.environ["PATH"] = self.path("bin") + os.pathsep + path
        code, _ = check(library, *FILLED, "--out", self.path("killed"), "--no-report")
        self.assertEqual(code, 1)
        killed = [row for row in report(self.path("killed"))["rows"] if "(Killed)" in row["why"]]
        self.assertGreater(len(killed), 0)
        self.assertEqual([row["stage"] for row in killed], ["solid"] * len(killed))
        self.assertEqual(len(lines(self.path("tries"))), 2 * len(killed), "each is tried once more")
        os.environ["PATH"] = path
        check(library, *FILLED, "--out", self.path("killed"), "--resume", "--no-report")
        self.assertEqual(without_times(report(self.path("killed"))), without_times(report(self.path("whole"))))

    def test_ctrl_c_keeps_what_is_done(self):
        library = self.small_library()
        run = subprocess.Popen([PROGRAM, "check", library, "--quick", "--out", self.path("out"), "--no-report"], stdout=subprocess.PIPE, text=True)
        deadline = time.time() + PATIENCE
        while time.time() < deadline and not (os.path.exists(self.path("out", "rows.jsonl")) and lines(self.path("out", "rows.jsonl"))):
            time.sleep(0.02)
        run.send_signal(signal.SIGINT)
        text, _ = run.communicate(timeout=PATIENCE)
        kept = report(self.path("out"))["rows"]
        self.assertGreaterEqual(len(kept), 1)
        self.assertLess(len(kept), 7)
        self.assertEqual(run.returncode, 130)
        self.assertIn("--resume goes on", text)

    def test_only_what_did_not_fail_before_fails_against_a_baseline(self):
        library = self.small_library()
        check(library, *SURFACES, "--out", self.path("first"), "--no-report")
        code, text = check(library, *SURFACES, "--out", self.path("second"), "--no-report", "--baseline", self.path("first", "report.json"))
        self.assertEqual(code, 0, text)
        with open(os.path.join(library, "ball.off"), "ab") as file:
            file.seek(0)
            file.truncate(200)
        code, text = check(library, *SURFACES, "--out", self.path("third"), "--no-report", "--baseline", self.path("first", "report.json"))
        self.assertEqual(code, 1)
        self.assertIn("ball.off", text)
        self.assertNotIn("nan.obj", text)

    def test_time_and_memory_cost_one_row(self):
        self.write("large.off", mesh_shapes.write_off(*mesh_shapes.icosphere(5)))
        self.write("small.off", b"")
        check(self.path("library"), "--out", self.path("slow"), "--timeout", 0.7, "--no-report")
        rows = self.rows(self.path("slow"))
        self.assertEqual(rows["large.off"]["verdict"], "fail")
        self.assertRegex(rows["large.off"]["why"], "^timeout: ran longer than 0.7 s")
        self.assertIn(rows["large.off"]["stage"], STAGES)
        self.assertRegex(rows["small.off"]["why"], "empty|timeout")  # on a busy machine a program takes as long to start
        with open(self.path("slow", "rows.jsonl"), encoding="utf-8") as file:
            small = next(line for line in file if '"small.off"' in line)
        check(self.path("library"), *SURFACES, "--out", self.path("slow"), "--resume", "--timeout", 100, "--no-report", ok=(2,))
        check(self.path("library"), "--out", self.path("slow"), "--resume", "--timeout", 3, "--no-report")
        self.assertRegex(self.rows(self.path("slow"))["large.off"]["why"], "^timeout: ran longer than 3 s")  # again, for longer
        self.assertIn(small, lines(self.path("slow", "rows.jsonl")))  # not again
        check(self.path("library"), "--out", self.path("tight"), "--memory", 0.09, "--no-report")
        row = self.rows(self.path("tight"))["large.off"]
        self.assertEqual(row["verdict"], "fail")
        self.assertRegex(row["why"], "memory|crash|error")

    def test_other_settings_and_wrong_words_are_refused(self):
        library = self.small_library()
        check(self.path("library", "empty.off"), "--quick", "--out", self.path("out"), "--no-report")
        for arguments, reason in ((["--out", "out", "--resume"], 'other settings: "quick" true, not false;'), (["--shard", "3/2"], "must be I/N"), (["--baseline", "none.json"], "cannot be read")):
            run = subprocess.run([PROGRAM, "check", os.path.join(library, "empty.off"), *arguments], cwd=self.folder, capture_output=True, text=True)
            self.assertEqual(run.returncode, 2)
            self.assertRegex(run.stderr, reason)
        with open(self.path("out", "rows.jsonl.settings.json"), encoding="utf-8") as file:
            settings = json.load(file)
        with open(self.path("out", "rows.jsonl.settings.json"), "w", encoding="utf-8") as file:
            json.dump(dict(settings, quick="a" * 5000), file)
        run = subprocess.run([PROGRAM, "check", os.path.join(library, "empty.off"), "--out", "out", "--resume"], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(run.returncode, 2)
        self.assertLess(len(run.stderr), 300, "a line that can be read")
        run = subprocess.run([PROGRAM, "check", self.path("nowhere")], capture_output=True, text=True)
        self.assertEqual(run.returncode, 2)
        self.assertIn("no such file or folder", run.stderr)

    def test_broken_files_have_the_right_reasons(self):
        kinds = len(variants.DEEDS)
        variants.make(self.path("variants"), *((2 * kinds, 1) if LONG else (kinds, 3)))  # each kind of fault twice, or once; where that is quick
        check(self.path("variants"), *FILLED, "--jobs", 2, "--out", self.path("out"), "--no-report")
        with open(self.path("variants", "expected.json"), encoding="utf-8") as file:
            expected = json.load(file)
        rows = self.rows(self.path("out"))
        self.assertEqual(sorted(rows), sorted(expected))
        wrong = {name: variants.differences(rows[name], wanted) for name, wanted in expected.items()}
        self.assertEqual({name: found for name, found in wrong.items() if found}, {})


if __name__ == "__main__":
    unittest.main()
