#!/usr/bin/python3
"""kilotouch paper: the paper's settings, all of its claims, the extended method beside them. KILOTOUCH names the program."""
import json
import os
import subprocess
import tempfile
import unittest

from patience import PATIENCE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))


def paper(folder, *arguments):
    result = subprocess.run([PROGRAM, "paper", "--out", folder, *arguments], capture_output=True, text=True, timeout=PATIENCE)
    with open(os.path.join(folder, "paper.json"), encoding="utf-8") as file:
        return result, json.load(file)


class Paper(unittest.TestCase):
    def test_claims_hold_by_the_papers_own_method(self):
        with tempfile.TemporaryDirectory() as folder:
            result, report = paper(folder)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
            self.assertEqual(len(report["claims"]), 5)
            for claim in report["claims"]:
                self.assertTrue(claim["holds"], claim)
            rows = report["table"]
            self.assertEqual([row["method"] for row in rows], ["paper"] * 3 + ["extended"] * 5)
            for row in rows[:3]:
                self.assertEqual((row["blend_ms"], row["refresh_hz"]), (0, 10), row)
                self.assertTrue(row["reducer"].startswith("wall"), row)
                self.assertLess(row["step_us_p50"], 60, row)  # 6 us on a quiet machine
            for name in ("slide", "stick", "stick_slip"):
                with open(os.path.join(folder, name, "summary.json"), encoding="utf-8") as file:
                    settings = json.load(file)["settings"]
                self.assertEqual(settings["object"]["model"]["least_volume"], 0)
                self.assertEqual(settings["global"]["rate_hz"], 10)
                for key in ("early_refresh", "look_ahead"):
                    self.assertIs(settings["global"][key], False, key)
                local = settings["local"]
                self.assertEqual((local["reducer"], local["rings"], local["catch_up"], local["blend_ms"]), ("wall", 1, False, 0))

    def test_a_tool_that_never_touches_shows_nothing(self):
        with tempfile.TemporaryDirectory() as folder:
            result, report = paper(folder, "--set", "tool.path.waypoints=[[0,0,0,1],[1,0,0,1]]", "--set", "duration=0.3")
            self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
            self.assertFalse(any(claim["holds"] for claim in report["claims"]), report["claims"])


if __name__ == "__main__":
    unittest.main()
