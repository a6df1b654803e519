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
from report_parts import check_page  # noqa: E402
from report_parts.drawing import CAN_DRAW  # noqa: E402

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

    @unittest.skipUnless(CAN_DRAW, "needs matplotlib")
    def test_draws_no_histogram_of_nothing(self):
        drawn = []
        original, check_page.histogram = check_page.histogram, lambda axes, values, title, *rest: drawn.append(title)
        try:
            keys = ("step_us", "refresh_ms", "cpu_s", "error", "off", "buzz")
            self.assertEqual(check_page.histograms([dict.fromkeys(keys)]), "")
            check_page.histograms([{**dict.fromkeys(keys), "cpu_s": 2.0}])
        finally:
            check_page.histogram = original
        self.assertEqual(drawn, ["Whole check"])

    @unittest.skipUnless(CAN_DRAW, "needs matplotlib")
    def test_labels_do_not_overlap(self):
        plt = check_page.plt
        for values in ([0.114, 0.12, 0.132], [20.0, 60.0], [1.0, 30.0, 5000.0], [5.0]):
            figure, axes = plt.subplots(figsize=(4.7, 2.9))
            check_page.histogram(axes, values, "title", "label")
            figure.canvas.draw()
            ends = [label.get_window_extent() for label in axes.get_xticklabels(which="both") if label.get_text()]
            inside = sorted((box.x0, box.x1) for box in ends if box.width > 1)
            plt.close(figure)
            for (_, end), (start, _) in zip(inside, inside[1:]):
                self.assertLess(end, start, values)


if __name__ == "__main__":
    unittest.main()
