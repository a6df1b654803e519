#!/usr/bin/python3
"""The page of kilotouch check, made from small reports: words for people, and nothing that is empty."""
import json
import os
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "scripts"))
sys.dont_write_bytecode = True
from report_parts import charts, check_page  # noqa: E402

NAMES = check_page.STAGES


def row(path, **drag):
    stages = [{"name": name, "verdict": "pass", "why": "", "figures": {}, "times": {}} for name in NAMES]
    stages[NAMES.index("drag")].update(drag)
    return {"path": path, "verdict": "pass", "stage": "", "why": "", "triangles": 1280, "stages": stages, "times": {"cpu_s": 2.5},
            "real_time": {"keeps": "no", "told": "fem: no: a refresh takes 61 ms of 33.3 (reduce 55)"}}


def report(rows, left=0):
    return {"kilotouch": "0", "settings": {"budget": 2000, "young": 1e5, "quick": False}, "left": left, "rows": rows,
            "summary": {"meshes": len(rows), "pass": len(rows), "degraded": 0, "fail": 0, "triangles": 1280, "failed_in": {}},
            "times": {"cpu_s": 2.5, "worker_s": 3, "cpu_s_per_100000_triangles": None}}


def page_of(content):
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "report.json"), "w", encoding="utf-8") as file:
            json.dump(content, file)
        check_page.check_page(folder)
        with open(os.path.join(folder, "report.html"), encoding="utf-8") as file:
            return file.read()


class CheckPage(unittest.TestCase):
    def test_has_no_words_of_python(self):
        text = check_page.figures_text({"figures": {"evenly": True, "open": False, "error": None, "msd": {"wrapped": True}}, "times": {}})
        self.assertEqual(text.split("\n"), ["evenly: yes", "open: no", "error: –", "msd: {wrapped yes}"])
        page = page_of(report([row("a.off")]))
        head = page[page.index("<h1>"):page.index("<div class=cards>")]
        self.assertIn("quick no", head)
        self.assertIn("young 100000,", head)

    def test_says_that_a_run_was_stopped(self):
        self.assertNotIn("Stopped early", page_of(report([row("a.off")])))
        self.assertIn("Stopped early: 3 meshes not checked", page_of(report([row("a.off")], left=3)))

    def test_says_what_is_not_real_time(self):
        page = page_of(report([row("a.off")]))
        self.assertIn('"pace":"no"', page)
        self.assertIn("a refresh takes 61 ms of 33.3 (reduce 55)", page)

    def test_draws_no_histogram_of_nothing(self):
        keys = ("step_us", "refresh_ms", "cpu_s", "error", "off", "buzz")
        self.assertEqual(check_page.histograms([dict.fromkeys(keys)]), [])
        self.assertEqual([c["title"] for c in check_page.histograms([{**dict.fromkeys(keys), "cpu_s": 2.0}])], ["Whole check"])

    def test_a_histogram_counts_every_mesh_once(self):
        for values in ([0.114, 0.12, 0.132], [20.0, 60.0], [1.0, 30.0, 5000.0], [5.0], [5.0, 5.0, 0.0], [1e-9, 1.0, 1e9], list(range(1, 500))):
            chart = charts.histogram_chart("title", values, "label", "meshes")
            steps = chart["series"][0]
            self.assertEqual(sum(steps["y"]) // 2, sum(1 for v in values if v > 0), values)  # both ends of each stretch
            self.assertEqual(steps["x"], sorted(steps["x"]))
            if len({v for v in values if v > 0}) > 1:  # the least and the largest stand at the ends
                self.assertTrue(steps["y"][0] > 0 and steps["y"][-1] > 0, values)
            self.assertLessEqual(steps["x"][0], min(v for v in values if v > 0) * (1 + 1e-4))
            self.assertGreaterEqual(steps["x"][-1], max(values) * (1 - 1e-4))
            self.assertEqual(chart["x"]["log"], max(values) > 10 * min(v for v in values if v > 0))
        self.assertIn("1 are 0", charts.histogram_chart("title", [5.0, 5.0, 0.0], "label", "meshes")["note"])
        self.assertEqual(charts.histogram_chart("title", [0, 0], "label", "meshes")["empty"], "0 in all 2 meshes")


if __name__ == "__main__":
    unittest.main()
