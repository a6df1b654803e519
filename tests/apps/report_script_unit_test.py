#!/usr/bin/python3
"""scripts/report.py on small results made here: what it writes, and that half a result gives half a report."""
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPT = os.path.join(ROOT, "scripts", "report.py")
HEADER = "t,tool_x,tool_y,tool_z,force_x,force_y,force_z,f_n,f_t,mode,triangle,toi,gap,model_frame,step_us\n"


def has_matplotlib():
    return subprocess.run([sys.executable, "-c", "import matplotlib"], capture_output=True).returncode == 0


def write_trace(folder, rows=1000, law="stick_slip"):
    """A press and a drag: the tangential force grows until the cone, then drops."""
    with open(os.path.join(folder, "trace.csv"), "w") as file:
        file.write(HEADER)
        tangential = 0.0
        for i in range(rows):
            t, free = 0.001 * (i + 1), i < rows // 10
            depth = 0.0 if free else min(0.004, 0.04 * (t - 0.0001 * rows))
            normal = 12 * depth
            tangential = 0.0 if free or law == "slide" else tangential + 0.0002
            mode = "free" if free else "slide" if law == "slide" else "stick"
            if not free and law == "stick_slip" and tangential > normal:
                tangential, mode = 0.6 * normal, "frictional_slide"
            gap = 0.002 if free else 0.0
            file.write(f"{t},{0.02 + 0.05 * t},0.05,{0.034 - depth + gap},{-tangential},0,{normal},{normal},{tangential},{mode},"
                       f"{i // 50},0.5,{gap},{i // 33},{3 + math.sin(i) ** 2}\n")


def write_summary(folder, **more):
    data = {"scene": "a <slab>", "seed": 1, "hash": "00ff", "command": "kilotouch run a.json", "contact": {"mu": 0.5},
            "model": {"type": "msd", "nodes": 4, "triangles": 4}, "force": {"mean_n": 0.0123, "buzz": 0.02},
            "step_us": {"p50": 3.0, "p99": 4.0}, "warnings": ["mind the step"], **more}
    with open(os.path.join(folder, "summary.json"), "w") as file:
        json.dump(data, file)


def write_view(folder, shape="sphere", frames=2):
    rest = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.03, 0.03, 0.05]]
    moved = [point[:2] + [0.9 * point[2]] for point in rest]
    view = {"tool": {"shape": shape, "radius": 0.004}, "rest": rest, "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            "fixed": [0, 1, 2], "path": [[0.02, 0.03, 0.06], [0.03, 0.03, 0.05], [0.04, 0.03, 0.05]],
            "frames": [{"t": 0.1 * i, "tool": [0.03, 0.03, 0.049], "x": moved} for i in range(frames)]}
    with open(os.path.join(folder, "view.json"), "w") as file:
        json.dump(view, file)


class Report(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = self.temporary.name

    def tearDown(self):
        self.temporary.cleanup()

    def run_script(self, *arguments, status=0, quiet=True, **environment):
        result = subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True,
                                env={**os.environ, **environment})
        self.assertEqual(result.returncode, status, result.stderr)
        if quiet:
            self.assertEqual(result.stderr, "")
        return result.stderr

    def page(self, name="report.html", folder=None):
        with open(os.path.join(folder or self.folder, name), encoding="utf-8") as file:
            return file.read()

    def sub(self, name):
        path = os.path.join(self.folder, name)
        os.makedirs(path, exist_ok=True)
        return path

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_whole_result_gives_all_pictures_in_one_page(self):
        write_trace(self.folder)
        write_summary(self.folder)
        write_view(self.folder)
        self.run_script(self.folder)
        for name in ("force.png", "step_time.png", "mesh.png"):
            self.assertGreater(os.path.getsize(os.path.join(self.folder, name)), 10000, name)
        page = self.page()
        self.assertEqual(page.count("data:image/png;base64,"), 3)
        self.assertFalse(re.search(r"(src|href)='?(?!'?data:)[^d']", page), "the page must stand alone")
        for words in ("mind the step", "0.0123 N", "kilotouch run a.json", "a &lt;slab&gt;", "2.00 %"):
            self.assertIn(words, page)

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_parts_of_a_result_give_parts_of_a_report(self):
        for make in (write_trace, write_summary, write_view):
            folder = self.sub(make.__name__)
            make(folder)
            self.run_script(folder)
            self.assertIn("</html>", self.page(folder=folder))

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_odd_traces_are_drawn(self):
        write_summary(self.folder)
        write_trace(self.folder)
        with open(os.path.join(self.folder, "trace.csv")) as file:
            whole = file.read()
        lines = whole.splitlines()
        odd = {"half a row at the end": whole[:len(whole) // 2], "one row": "\n".join(lines[:2]), "header only": lines[0],
               "never touches": "\n".join(lines[:90]), "gaps unknown": re.sub(r",0\.5,[0-9.]+,", ",0.5,nan,", whole)}
        for name, content in odd.items():
            with self.subTest(name):
                with open(os.path.join(self.folder, "trace.csv"), "w") as file:
                    file.write(content)
                self.run_script(self.folder)

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_point_tools_and_single_frames_are_drawn(self):
        write_view(self.folder, shape="point", frames=1)
        self.run_script(self.folder)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "mesh.png")))

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_a_second_tool_is_drawn(self):
        write_summary(self.folder)
        write_trace(self.folder, law="slide")
        os.rename(os.path.join(self.folder, "trace.csv"), os.path.join(self.folder, "trace_2.csv"))
        write_trace(self.folder)
        write_view(self.folder)
        path = os.path.join(self.folder, "view.json")
        with open(path) as file:
            view = json.load(file)
        self.run_script(self.folder)
        alone = {name: os.path.getsize(os.path.join(self.folder, name)) for name in ("mesh.png",)}
        view["second_tool"] = {"shape": "point", "radius": 0}
        view["second_path"] = [[0.02, 0.03, -0.01], [0.03, 0.03, -0.005]]
        for frame in view["frames"]:
            frame["second_tool"] = [0.03, 0.03, -0.005]
        with open(path, "w") as file:
            json.dump(view, file)
        self.run_script(self.folder)
        self.assertIn("both tools", self.page())
        self.assertNotEqual(os.path.getsize(os.path.join(self.folder, "mesh.png")), alone["mesh.png"])

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_runs_are_compared(self):
        for name in ("one", "two"):
            write_trace(self.sub(name))
            write_summary(self.sub(name))
        self.run_script(self.sub("one"), "--title", "both", "--compare", self.sub("two"))
        page = self.page(folder=self.sub("one"))
        self.assertIn("<h1>both</h1>", page)
        self.assertIn("<th class=number>two</th>", page)

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_paper_page_shows_claims_and_laws(self):
        for law in ("slide", "stick", "stick_slip", "coulomb_slide", "coulomb"):
            write_trace(self.sub(law), law=law)
        with open(os.path.join(self.folder, "paper.json"), "w") as file:
            json.dump({"claims": [{"text": "no friction", "value": 1e-17, "bound": 1e-12, "holds": True},
                                  {"text": "no buzz", "value": 1.0000001, "bound": 1, "holds": False}],
                       "table": [{"law": "paper_stick_slip", "metric": "identity", "buzz": 0.3, "crossing_jump": 2.5}]}, file)
        self.run_script("--paper", self.folder)
        page = self.page("paper.html")
        for words in ("1 of 2 claims hold", "1.0000001", "✗ does not hold", "250 %", "data:image/png"):
            self.assertIn(words, page)

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_paper_page_with_one_experiment(self):
        write_trace(self.sub("stick"), law="stick")
        self.run_script("--paper", self.folder)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "paper.png")))

    @unittest.skipUnless(has_matplotlib(), "needs matplotlib")
    def test_ten_thousand_rows_take_seconds(self):
        write_trace(self.folder, rows=10000)
        write_summary(self.folder)
        write_view(self.folder, frames=4)
        start = time.process_time(), os.times().children_user
        self.run_script(self.folder)
        self.assertLess(os.times().children_user - start[1], 6.0)

    def test_without_matplotlib_the_numbers_stay(self):
        fake = self.sub("fake")
        with open(os.path.join(fake, "matplotlib.py"), "w") as file:
            file.write("raise ImportError('hidden')\n")
        write_trace(self.folder)
        write_summary(self.folder)
        words = self.run_script(self.folder, status=3, quiet=False, PYTHONPATH=fake)
        self.assertIn("python3-matplotlib", words)
        self.assertIn("0.0123 N", self.page())

    def test_a_chart_without_a_point_is_left_out(self):
        with open(os.path.join(self.folder, "chart.json"), "w", encoding="utf-8") as file:
            json.dump({"processor": "one", "noticeable": 0.1, "seconds": 1, "stopped": True,
                       "axes": [{"key": "force_error", "title": "force error [%]", "is_cost": False},
                                {"key": "tick_p50_us", "title": "tick [us]", "is_cost": True}],
                       "charts": [{"name": "drag", "title": "drag", "scene": "", "references": [], "points": []}]}, file)
        self.run_script("--chart", self.folder)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "chart.html")))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "chart_drag.png")))

    def test_scripts_inside_pages_bring_their_licence(self):
        sys.path.insert(0, os.path.join(ROOT, "scripts"))
        self.addCleanup(sys.path.remove, os.path.join(ROOT, "scripts"))
        from report_parts import check_page, notices
        for name, holder in (("Chart.js", "Chart.js Contributors"), ("jQuery", "OpenJS"), ("DataTables", "SpryMedia")):
            text = notices.with_notice(name, "let a = 1;")
            self.assertTrue(text.startswith("/*!") and text.endswith("*/\nlet a = 1;"))
            self.assertIn(holder, text)
            self.assertIn("The above copyright notice and this permission notice shall be included", text)
            self.assertEqual(text.count("*/"), 1)
        scripts = check_page.script_files()
        if scripts is None:
            self.skipTest("libjs-jquery-datatables is not installed")
        self.assertEqual(scripts.count("Permission is hereby granted"), 2)

    def test_the_page_begins_with_real_time_and_trust(self):
        write_summary(self.folder, real_time={"keeps": "no", "told": "no: a refresh takes 61 ms of 33.3 (reduce 55)"}, notes=["the body <floats>"],
                      trust={"trustworthy": False, "reasons": [{"what": "jumps of 60 % at <edges>", "cure": "set contact.surface to loop"}]})
        subprocess.run([sys.executable, SCRIPT, self.folder], capture_output=True)
        page = self.page()
        places = [page.index(words) for words in ("<b>Real time:</b>", "(reduce 55)", "<b>Trustworthy:</b>", "jumps of 60 % at &lt;edges&gt;",
                                                  "set contact.surface to loop", "the body &lt;floats&gt;", "class=cards")]
        self.assertEqual(places, sorted(places))
        self.assertNotIn("mind the step", page)  # a warning is a reason, or a note

    def test_wrong_input_is_one_line(self):
        empty = self.sub("empty")
        damaged = self.sub("damaged")
        with open(os.path.join(damaged, "summary.json"), "w") as file:
            file.write("{")
        for arguments in ((os.path.join(self.folder, "nowhere"),), (empty,), (damaged,), ("--paper", empty)):
            words = self.run_script(*arguments, status=1, quiet=False)
            self.assertEqual(words.strip().count("\n"), 0, words)
            self.assertTrue(words.startswith("report.py: "), words)


if __name__ == "__main__":
    unittest.main()
