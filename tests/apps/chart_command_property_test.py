"""kilotouch chart: a small scene through every method; resumed; wrong input. Run with KILOTOUCH=path/to/kilotouch."""
import csv
import json
import os
import re
import subprocess
import tempfile
import unittest

from patience import PATIENCE

PROGRAM = os.path.abspath(os.environ["KILOTOUCH"])
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))

SCENE = {
    "duration": 0.12,
    "object": {"mesh": os.path.join(ROOT, "meshes/pad.off"), "fixed": {"below": {"axis": "z", "fraction": 0.05}}},
    "tool": {"shape": "sphere", "radius": 0.006,
             "path": {"press_drag": {"at": [0.02, 0.025], "depth": 0.002, "press_time": 0.02, "speed": 0.05}}},
}


def chart(folder, *arguments):
    return subprocess.run([PROGRAM, "chart", *arguments], cwd=folder, capture_output=True, text=True, timeout=PATIENCE)


class Chart(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.folder = cls.holder.name
        with open(os.path.join(cls.folder, "tiny.json"), "w", encoding="utf-8") as file:
            json.dump(SCENE, file)
        cls.process = chart(cls.folder, "tiny.json", "--out", "chart", "--reference-rate", "8000", "--json", "copy.json")

    @classmethod
    def tearDownClass(cls):
        cls.holder.cleanup()

    def path(self, name):
        return os.path.join(self.folder, "chart", name)

    def rows(self):
        with open(self.path("chart.csv"), encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def test_every_method_has_a_row_with_error_cost_settings_and_hash(self):
        self.assertEqual(self.process.returncode, 0, self.process.stderr)
        rows = self.rows()
        self.assertGreater(len(rows), 30)
        self.assertEqual(len({row["label"] + row["family"] for row in rows}), len(rows))
        for row in rows:
            self.assertEqual(row["outcome"], "done", row)
            self.assertGreaterEqual(float(row["force_error"]), 0)
            self.assertGreater(float(row["tick_p50_us"]), 0)
            self.assertGreater(float(row["refresh_ms"]), 0, row)
            self.assertRegex(row["hash"], "^[0-9a-f]{16}$")
            self.assertIn("kilotouch run tiny.json", row["command"])

    def test_a_broad_phase_changes_no_bit_and_a_baseline_does(self):
        hashes = {row["label"]: row["hash"] for row in self.rows()}
        ours = hashes["auto, 30 Hz"]
        for backend in ("refit_bvh, 30 Hz", "embree, 30 Hz", "brute_force, 30 Hz"):
            if backend in hashes:
                self.assertEqual(hashes[backend], ours)
        self.assertNotEqual(hashes["hold, 30 Hz"], ours)

    def test_the_front_is_of_points_that_none_beats(self):
        points = [(float(r["tick_p50_us"]), float(r["force_error"]), r["pareto"]) for r in self.rows()]
        for cost, error, pareto in points:
            beaten = any(c <= cost and e <= error and (c, e) != (cost, error) for c, e, _ in points)
            self.assertEqual(pareto, "false" if beaten else "true")

    def test_the_truth_says_how_far_it_has_converged(self):
        with open(os.path.join(self.folder, "copy.json"), encoding="utf-8") as file:
            truth = json.load(file)["charts"][0]["references"]
        self.assertEqual(len(truth), 1)
        self.assertGreater(truth[0]["change_by_halving"], 0)
        self.assertLess(truth[0]["change_by_halving"], 0.2)

    def test_the_page_needs_nothing_else(self):
        for name in ("chart.html", "chart_tiny.png", "chart_tiny.svg", "chart.json"):
            self.assertTrue(os.path.getsize(self.path(name)) > 0, name)
        with open(self.path("chart.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertIsNone(re.search(r"""(src|href)=["']?(http|//|/|\.)""", page))

    def test_resuming_runs_nothing_again(self):
        with open(self.path("runs.jsonl"), encoding="utf-8") as file:
            lines = file.readlines()
        with open(self.path("runs.jsonl"), "w", encoding="utf-8") as file:
            file.writelines(lines[:-2] + [lines[-2][:40]])  # killed while it wrote
        before = self.rows()
        again = chart(self.folder, "tiny.json", "--out", "chart", "--reference-rate", "8000", "--resume", "--no-report")
        self.assertEqual(again.returncode, 0, again.stderr)
        with open(self.path("runs.jsonl"), encoding="utf-8") as file:
            now = file.readlines()
        self.assertEqual(now[:len(lines) - 2], lines[:-2])
        self.assertEqual(len(now), len(lines))
        self.assertEqual([r["hash"] for r in self.rows()], [r["hash"] for r in before])

    def test_wrong_input_is_one_line(self):
        hand = dict(SCENE, tool={"path": {"hand": {"target": [[0, 0.02, 0.02, 0.03]]}}})
        with open(os.path.join(self.folder, "hand.json"), "w", encoding="utf-8") as file:
            json.dump(hand, file)
        with open(os.path.join(self.folder, "two.json"), "w", encoding="utf-8") as file:
            json.dump(dict(SCENE, second_tool={}), file)
        for arguments, words in (
                (("none.json",), "none.json"), (("hand.json",), "tool.path.hand"),
                (("two.json",), "second_tool"), (("tiny.json", "tiny.json"), "two scenes"),
                (("tiny.json", "--jobs", "0"), "--jobs"), (("tiny.json", "--reference-rate", "-1"), "--reference-rate"),
                (("tiny.json", "--json", "no/folder/x.json"), "no/folder")):
            run = chart(self.folder, *arguments, "--out", "wrong")
            self.assertEqual(run.returncode, 2, arguments)
            self.assertEqual(run.stderr.count("\n"), 1, run.stderr)
            self.assertIn(words, run.stderr)
            self.assertFalse(os.path.exists(os.path.join(self.folder, "wrong")), arguments)


if __name__ == "__main__":
    unittest.main()
