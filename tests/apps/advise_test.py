#!/usr/bin/python3
"""kilotouch advise: the shape of its answer on a small body. KILOTOUCH names the program."""
import json
import os
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
# An octahedron of 6 cm: the tetrahedralizer has little to fill.
BODY = "OFF\n6 8 0\n3 0 0\n-3 0 0\n0 3 0\n0 -3 0\n0 0 3\n0 0 -3\n" + "".join(
    f"3 {a} {b} {c}\n" for a, b, c in [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)])
SCENE = {
    "object": {"mesh": "body.off", "scale": 0.01, "fixed": {"below": {"axis": "z", "fraction": 0.3}},
               "tetrahedralize": {"max_volume": 4e-7}, "model": {"type": "fem", "young": 1e4}},
    "duration": 0.25,
    "tool": {"shape": "sphere", "radius": 0.008,
             "path": {"press_drag": {"at": [0.004, 0.004], "depth": 0.002, "press_time": 0.1, "speed": 0.02}}},
}


class Advise(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        for name, content in (("body.off", BODY), ("scene.json", json.dumps(SCENE))):
            with open(os.path.join(self.temporary.name, name), "w", encoding="utf-8") as file:
                file.write(content)

    def advise(self, *arguments):
        """Exit code, standard output and the JSON."""
        result = subprocess.run([PROGRAM, "advise", "scene.json", "--json", "a.json", *arguments],
                                cwd=self.temporary.name, capture_output=True, text=True, timeout=250)
        self.assertEqual(result.stderr, "")
        with open(os.path.join(self.temporary.name, "a.json"), encoding="utf-8") as file:
            return result.returncode, result.stdout, json.load(file)

    def assert_shape(self, answer):
        for key in ("tolerance", "found", "reason", "settings", "body", "row", "truth", "bodies", "reference", "rows",
                    "notes", "seconds", "stopped"):
            self.assertIn(key, answer)
        for body in answer["bodies"]:
            for key in ("model", "max_volume", "nodes", "tets", "measured", "force", "error", "global_ms", "verdict"):
                self.assertIn(key, body)
        for row in answer["rows"]:
            self.assertTrue(row["verdict"])
            if row["measured"]:
                for key in ("error", "jnd_fraction", "global_ms", "refresh_ms", "step_us", "core_share", "dof"):
                    self.assertIn(key, row)

    def test_a_wide_tolerance_finds_a_row_that_runs(self):
        code, text, answer = self.advise("--tolerance", "5", "--budget-seconds", "60")
        self.assert_shape(answer)
        self.assertEqual(code, 0, text)
        self.assertTrue(answer["found"])
        self.assertIn("advice:", text)
        row = answer["rows"][answer["row"]]
        self.assertEqual(row["verdict"], "fits")
        for other in answer["rows"]:
            if other["verdict"] == "fits":
                self.assertGreaterEqual(other["core_share"], row["core_share"])
        settings = [word for s in answer["settings"] for word in ("--set", s)]
        run = subprocess.run([PROGRAM, "run", "scene.json", *settings, "--no-report", "--out", "out"],
                             cwd=self.temporary.name, capture_output=True, text=True, timeout=100)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_no_row_within_a_tiny_tolerance_names_the_nearest(self):
        code, text, answer = self.advise("--tolerance", "1e-6", "--budget-seconds", "60")
        self.assert_shape(answer)
        self.assertEqual(code, 1)
        self.assertFalse(answer["found"])
        self.assertIn("nearest", answer["reason"])
        self.assertIn("nearest", text)

    def test_a_point_keeps_its_model_and_says_why(self):
        code, text, answer = self.advise("--set", "tool.shape=point", "--tolerance", "5", "--budget-seconds", "60")
        self.assertEqual(len(answer["bodies"]), 1)
        self.assertIn("point", answer["bodies"][0]["verdict"])
        self.assertIn("kept unjudged", answer["reason"])

    def test_a_spent_budget_names_what_was_not_measured(self):
        _, _, answer = self.advise("--budget-seconds", "1")
        self.assert_shape(answer)
        left_out = [r for r in answer["bodies"] + answer["rows"] if not r["measured"]]
        for row in left_out:
            self.assertIn("not measured", row["verdict"])


if __name__ == "__main__":
    unittest.main()
