#!/usr/bin/python3
"""kilotouch stability as other programs rely on it: exit codes, files, keys. KILOTOUCH names the program."""
import csv
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from patience import PATIENCE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
QUICK = "mass_and_damping"  # one of the fastest maps
COLUMNS = ["series", "x", "y", "verdict", "why", "value", "predicted_failure", "prediction", "hash"]
COUNTS = ["points", "failures", "predicted", "degraded", "degraded_warned", "working", "false_alarms", "alarms"]
HAS_MATPLOTLIB = subprocess.run(["/usr/bin/python3", "-c", "import numpy, matplotlib"], capture_output=True).returncode == 0


def rows_of(*path):
    with open(os.path.join(*path), newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class Stability(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = self.temporary.name

    def kilotouch(self, *arguments, status=0):
        result = subprocess.run([PROGRAM, "stability", *arguments], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(result.returncode, status, result.stdout + result.stderr)
        return result

    def test_unknown_maps_are_one_line_with_the_known_ones(self):
        error = self.kilotouch("mass_and_dumping", "--out", "o", status=2).stderr
        self.assertEqual(error.count("\n"), 1)
        self.assertIn('did you mean "mass_and_damping"', error)
        self.assertIn("time_step", error)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "o")), "nothing is written for wrong input")

    def test_one_map_writes_tables_facts_pictures_and_page_twice_the_same(self):
        result = self.kilotouch(QUICK, "--out", "one", "--json", "one.json")
        self.kilotouch(QUICK, "--out", "two", "--no-report", "--jobs", "1")
        self.assertIn(QUICK, result.stdout)
        out = os.path.join(self.folder, "one")
        points, lines = rows_of(out, QUICK + ".csv"), rows_of(out, QUICK + "_boundaries.csv")
        self.assertEqual(list(points[0]), COLUMNS)
        self.assertEqual({p["verdict"] for p in points} - {"works", "degrades", "fails"}, set())
        self.assertTrue(any(line["theory"] == "1" for line in lines) and any(line["theory"] == "0" for line in lines))
        self.assertEqual(points, rows_of(self.folder, "two", QUICK + ".csv"), "the same bits on one thread and on two")
        with open(os.path.join(out, "stability.json"), encoding="utf-8") as file:
            facts = json.load(file)
        with open(os.path.join(self.folder, "one.json"), encoding="utf-8") as file:
            self.assertEqual(facts, json.load(file))
        self.assertEqual([m["name"] for m in facts["maps"]], [QUICK])
        counts = facts["maps"][0]["confusion"]
        self.assertEqual(list(counts), COUNTS)
        self.assertEqual(facts["sum"], counts)
        fails = [p for p in points if p["verdict"] == "fails"]
        self.assertEqual(counts["points"], len(points))
        self.assertEqual(counts["failures"], len(fails))
        self.assertEqual(counts["predicted"], sum(p["predicted_failure"] == "1" for p in fails))
        self.assertGreater(facts["maps"][0]["seconds"], 0)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "two", "stability.html")))
        if not HAS_MATPLOTLIB:
            return
        for name in (QUICK + ".png", QUICK + ".svg", "stability.html"):
            self.assertTrue(os.path.getsize(os.path.join(out, name)) > 1000, name)
        with open(os.path.join(out, "stability.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertIn("data:image/png;base64,", page)
        self.assertNotIn("src='http", page)

    def test_ctrl_c_keeps_what_is_there(self):
        child = subprocess.Popen([PROGRAM, "stability", "--out", "stopped", "--no-report"], cwd=self.folder, text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        time.sleep(2)
        child.send_signal(signal.SIGINT)
        out, error = child.communicate(timeout=PATIENCE)
        self.assertEqual(child.returncode, 130, out + error)
        with open(os.path.join(self.folder, "stopped", "stability.json"), encoding="utf-8") as file:
            self.assertTrue(json.load(file)["stopped"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
