#!/usr/bin/python3
"""kilotouch advise: the shape of its answer on a small body. KILOTOUCH names the program."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

from patience import PATIENCE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
sys.path.insert(0, os.path.join(ROOT, "scripts"))
from mesh_shapes import box, write_off  # noqa: E402

BODY = write_off(*box(4, 4, 1)).decode()
SCENE = {
    "object": {"mesh": "body.off", "scale": 0.01, "fixed": {"below": {"axis": "z", "fraction": 0.05}},
               "model": {"type": "fem", "young": 1e4}},
    "duration": 0.15,
    "tool": {"shape": "sphere", "radius": 0.008,
             "path": {"press_drag": {"at": [0.022, 0.026], "depth": 0.002, "press_time": 0.1, "speed": 0.02}}},
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
                                cwd=self.temporary.name, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(result.stderr, "")
        with open(os.path.join(self.temporary.name, "a.json"), encoding="utf-8") as file:
            return result.returncode, result.stdout, json.load(file)

    def assert_shape(self, answer):
        for key in ("tolerance", "found", "reason", "settings", "row", "truth", "bodies", "rows", "seconds", "stopped"):
            self.assertIn(key, answer)
        for body in answer["bodies"]:
            for key in ("model", "mesh", "nodes", "force", "error", "refresh_ms"):
                self.assertIn(key, body)
            self.assertTrue(body["verdict"])
        for row in answer["rows"]:
            for key in ("body", "rate_hz", "reducer", "rates_error", "error", "global_ms", "refresh_ms", "core_share"):
                self.assertIn(key, row)
            self.assertTrue(row["verdict"])

    def test_a_wide_tolerance_finds_the_cheapest_row_and_it_runs(self):
        code, text, answer = self.advise("--tolerance", "5", "--budget-seconds", "400")
        self.assert_shape(answer)
        self.assertEqual(code, 0, text)
        self.assertTrue(answer["found"])
        self.assertIn("recommended:", text)
        self.assertLess(answer["truth"]["uncertainty"], 0.1)
        self.assertLessEqual({"auto", "krylov", "condensed", "wall"}, {row["reducer"] for row in answer["rows"]})
        row = answer["rows"][answer["row"]]
        self.assertEqual(row["verdict"], "fits")
        self.assertAlmostEqual(row["error"], row["rates_error"] + answer["bodies"][row["body"]]["error"])
        for other in answer["rows"]:
            if other["verdict"] == "fits":
                self.assertGreaterEqual(other["core_share"], row["core_share"])
        settings = [word for s in answer["settings"] for word in ("--set", s)]
        run = subprocess.run([PROGRAM, "run", "scene.json", *settings, "--no-report", "--out", "out"],
                             cwd=self.temporary.name, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(run.returncode, 0, run.stderr)

    def test_cells_refined_under_the_tool_are_judged_beside_the_cells_as_they_are(self):
        _, _, answer = self.advise("--tolerance", "0.15", "--budget-seconds", "400")
        errors = {(b["model"], b["refined"]): b["error"] for b in answer["bodies"] if b["mesh"] == "own"}
        self.assertLess(errors["tet4", True], 0.15)
        self.assertGreater(errors["tet4", False], 2 * errors["tet4", True])
        self.assertIn("local.refine=follow", answer["settings"])

    def test_no_row_within_a_tiny_tolerance_names_the_nearest(self):
        code, text, answer = self.advise("--set", "local.refine=off", "--tolerance", "1e-6", "--budget-seconds", "400")
        self.assert_shape(answer)
        self.assertEqual(code, 1)
        self.assertFalse(answer["found"])
        self.assertFalse(any(b["refined"] for b in answer["bodies"]))
        self.assertIn("nearest, not within the tolerance: kilotouch run", text)

    def test_a_point_keeps_its_body_and_says_why(self):
        code, text, answer = self.advise("--set", "tool.shape=point", "--tolerance", "5", "--budget-seconds", "400")
        self.assertEqual(code, 0, text)
        self.assertEqual(len(answer["bodies"]), 1)
        self.assertIn("not judged: the force on a point", answer["bodies"][0]["verdict"])
        self.assertIn("not judged", answer["reason"])

    def test_a_spent_budget_names_what_was_not_judged(self):
        _, text, answer = self.advise("--budget-seconds", "5")
        self.assert_shape(answer)
        self.assertIn("rows not judged", text)
        verdicts = [row["verdict"] for row in answer["bodies"] + answer["rows"]]  # on a busy machine it ends in the first press
        self.assertTrue(any("beyond the time budget" in v or "was ended before it came to rest" in v for v in verdicts), verdicts)


if __name__ == "__main__":
    unittest.main()
