#!/usr/bin/python3
"""scripts/report.py on small results made here: what it writes, and that half a result gives half a report."""
import base64
import contextlib
import json
import math
import os
import re
import runpy
import struct
import subprocess
import sys
import tempfile
import traceback
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCRIPT = os.path.join(ROOT, "scripts", "report.py")
HEADER = "t,tool_x,tool_y,tool_z,force_x,force_y,force_z,f_n,f_t,mode,triangle,toi,gap,model_frame,step_us\n"


try:  # once, for all runs of the script
    import jinja2
except ImportError:
    pass
try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot
    HAS_MATPLOTLIB = True
except ImportError:
    HAS_MATPLOTLIB = False

HAS_CHARTS = os.path.exists("/usr/share/javascript/chart.js/chart.min.js")
HAS_PLAYER = os.path.exists("/usr/share/javascript/three/three.min.js")


def in_own_process(arguments, environment):
    result = subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, env={**os.environ, **environment})
    return result.returncode, result.stderr


def in_this_process(arguments, _):
    """The same here, where the libraries are imported and their fonts found: that takes longer than the script."""
    kept, status = (sys.argv, sys.path[:], sys.stderr, sys.stdout, os.dup(2)), 1
    with tempfile.TemporaryFile() as errors:
        os.dup2(errors.fileno(), 2)
        sys.stderr, sys.stdout = open(2, "w", closefd=False), open(os.devnull, "w")
        sys.argv = [SCRIPT, *arguments]
        sys.path.insert(0, os.path.dirname(SCRIPT))
        try:
            with matplotlib.rc_context() if HAS_MATPLOTLIB else contextlib.nullcontext():
                runpy.run_path(SCRIPT, run_name="__main__")
            status = 0
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
            if isinstance(end.code, str):
                sys.stderr.write(end.code + "\n")
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stderr.flush()
            sys.stdout.close()
            sys.argv, sys.path[:], sys.stderr, sys.stdout, stderr = kept
            os.dup2(stderr, 2)
            os.close(stderr)
        errors.seek(0)
        return status, errors.read().decode()


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


def write_view(folder, shape="sphere", frames=2, film=0, nodes=4):
    rest = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.03, 0.03, 0.05]]
    moved = [point[:2] + [0.9 * point[2]] for point in rest]
    view = {"tool": {"shape": shape, "radius": 0.004}, "rest": rest, "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
            "fixed": [0, 1, 2], "path": [[0.02, 0.03, 0.06], [0.03, 0.03, 0.05], [0.04, 0.03, 0.05]],
            "frames": [{"t": 0.1 * i, "tool": [0.03, 0.03, 0.049], "x": moved} for i in range(frames)]}
    if film:  # a pyramid that sinks by a tenth from frame to frame; further nodes that no triangle has, for size
        step = 0.1 / 65535
        pack = lambda points: base64.b64encode(struct.pack(f"<{3 * nodes}H", *(round(c / step) for p in points for c in p), *[0] * (3 * nodes - 12))).decode()
        sunk = lambda k: [point[:2] + [0.9 ** min(k, 5) * point[2]] for point in rest]
        view["film"] = {"interval": 0.1, "low": [0, 0, 0], "step": step, "rest": pack(rest), "t": [round(0.1 * k, 6) for k in range(film)], "x": [pack(sunk(k)) for k in range(film)]}
    with open(os.path.join(folder, "view.json"), "w") as file:
        json.dump(view, file)


class Report(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = self.temporary.name

    def tearDown(self):
        self.temporary.cleanup()

    def run_script(self, *arguments, status=0, quiet=True, **environment):
        run = in_own_process if environment else in_this_process
        returned, errors = run(arguments, environment)
        self.assertEqual(returned, status, errors)
        if quiet:
            self.assertEqual(errors, "")
        return errors

    def page(self, name="report.html", folder=None):
        with open(os.path.join(folder or self.folder, name), encoding="utf-8") as file:
            return file.read()

    def assert_has(self, text, words):
        self.assertTrue(words in text, f"not in the page: {words}")

    def assert_stands_alone(self, page):
        """No file and no address is needed: what has a source has it inside."""
        outside = re.sub(r"<script.*?</script>", "", page, flags=re.S)
        self.assertEqual(re.findall(r"""(?:src|href)=(?!["']?data:)[^ >]{,60}""", outside), [])
        self.assertNotRegex(page, r"<script[^>]* src=")
        self.assertNotIn("@import", page)

    def specs(self, page):
        """The charts of a page, as the browser gets them."""
        return [json.loads(text) for text in re.findall(r'<script type="application/json">(.*?)</script>', page, re.S)]

    def sub(self, name):
        path = os.path.join(self.folder, name)
        os.makedirs(path, exist_ok=True)
        return path

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_whole_result_gives_all_pictures_in_one_page(self):
        write_trace(self.folder)
        write_summary(self.folder)
        write_view(self.folder)
        self.run_script(self.folder)
        for name in ("force.png", "mesh.png"):
            self.assertGreater(os.path.getsize(os.path.join(self.folder, name)), 10000, name)
        page = self.page()
        self.assert_stands_alone(page)
        for words in ("mind the step", "0.0123 N", "kilotouch run a.json", "a &lt;slab&gt;", "2.00 %"):
            self.assert_has(page, words)
        if HAS_CHARTS:
            self.assertEqual([c["title"] for c in self.specs(page)], ["Force on the tool", "Processor time of a haptic tick"])
        self.assertEqual(page.count("data:image/png;base64,"), 1 if HAS_CHARTS else 2)  # mesh.png; forces are a chart

    @unittest.skipUnless(HAS_MATPLOTLIB and HAS_CHARTS, "needs matplotlib and libjs-chart.js")
    def test_curves_keep_their_peaks_and_modes_their_times(self):
        """100 000 ticks with one spike: fewer points, and the spike is there."""
        write_trace(self.folder, rows=20000)
        path = os.path.join(self.folder, "trace.csv")
        with open(path) as file:
            lines = file.read().splitlines()
        cells = lines[12346].split(",")
        cells[7] = "7.5"
        lines[12346] = ",".join(cells)
        with open(path, "w") as file:
            file.write("\n".join(lines) + "\n")
        self.run_script(self.folder)
        chart = self.specs(self.page())[0]
        force = next(s for s in chart["series"] if s["label"] == "normal force")["y"]
        self.assertLess(len(force), 3000)
        self.assertEqual(len(force), len(chart["x"]["values"]))
        self.assertEqual(max(force), 7.5)
        self.assertAlmostEqual(chart["x"]["values"][force.index(7.5)], 12.346, 6)
        self.assertEqual(chart["bands"][0], [2.001, {"free": 1}])  # until the first tick that touches
        self.assertEqual(chart["bands"][-1][0], 20.0)

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_lengths_that_mean_nothing_have_no_digits(self):
        sys.path.insert(0, os.path.join(ROOT, "scripts"))
        self.addCleanup(sys.path.remove, os.path.join(ROOT, "scripts"))
        from report_parts.words import ENERGY, FORCE, LENGTH
        self.assertEqual([LENGTH(v) for v in (9.94e-13, -2e-10, 0.0, 3e-9, 2.5e-6, 0.003, 0.25)], ["< 1 nm", "< 1 nm", "0 m", "3.00 nm", "2.50 µm", "3.00 mm", "250 mm"])
        self.assertEqual([FORCE(v) for v in (1.37e-17, 0.0, 2e-6, 0.226)], ["< 1 µN", "0 N", "2.00e-6 N", "0.226 N"])
        self.assertEqual([ENERGY(v) for v in (-1e-12, -3e-7, 2.0)], ["< 1 nJ", "-300 nJ", "2.00 J"])
        write_summary(self.folder, penetration_max_m=9.94e-13)
        self.run_script(self.folder)
        self.assert_has(self.page(), "&lt; 1 nm")

    def test_what_people_notice_is_marked_with_its_cure(self):
        """7 % and 10 % of a force are the limits; the run's own reason gives the cure where it has one."""
        sys.path.insert(0, os.path.join(ROOT, "scripts"))
        self.addCleanup(sys.path.remove, os.path.join(ROOT, "scripts"))
        from report_parts.words import noticed
        level = lambda value: noticed({"force": {"buzz": value}}, "force.buzz")[0]
        self.assertEqual([level(v) for v in (0.069, 0.071, 0.099, 0.101)], ["", "perhaps", "perhaps", "yes"])
        self.assertEqual(noticed({"mesh_at_contact": {"force_factor": 0.8}}, "mesh_at_contact.force_factor")[0], "yes")
        self.assertEqual(noticed({"force": {"buzz": None}}, "force.buzz"), ("", ""))
        write_summary(self.folder, force={"mean_n": 0.1, "crossing_jump": 0.6, "refresh_jump": 0.08},
                      trust={"trustworthy": False, "reasons": [{"what": "the force jumps by up to 60 % of its mean in one tick at an edge of the mesh", "cure": "set contact.surface to loop (stiffer)"}]})
        in_this_process([self.folder], {})
        rows = re.findall(r"<tr class=marked>.*?</tr>", self.page(), re.S)
        self.assertEqual(len(rows), 2)
        self.assert_has(rows[0], "jump at a mesh line")
        self.assert_has(rows[0], "more than people notice (7–10 % of a force)</span>: set contact.surface to loop (stiffer)")
        self.assert_has(rows[1], "people may notice this (7–10 % of a force)</span>: set local.blend_ms to 12")

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_indentation_is_drawn_where_the_run_has_it(self):
        write_trace(self.folder)
        path = os.path.join(self.folder, "trace.csv")
        with open(path) as file:
            head, *rows = file.read().splitlines()
        with open(path, "w") as file:
            file.write("\n".join([head + ",indentation"] + [row + (",0" if ",free," in row else ",0.003") for row in rows]) + "\n")
        write_summary(self.folder)
        self.run_script(self.folder)
        page = self.page()
        self.assert_has(page, "<b>3.00 mm</b><span>deepest indentation along the contact normal</span>")
        if HAS_CHARTS:
            depth = self.specs(page)[1]["series"][0]["y"]
            self.assertEqual((depth[0], depth[-1]), (None, 3.0))  # none without contact, in mm with it

    @unittest.skipUnless(HAS_MATPLOTLIB and HAS_PLAYER, "needs matplotlib and libjs-three")
    def test_the_player_has_the_body_and_the_tools_way(self):
        write_trace(self.folder)
        write_summary(self.folder)
        write_view(self.folder, film=4)
        self.run_script(self.folder)
        page = self.page()
        self.assert_stands_alone(page)
        data = json.loads(re.search(r'id=player-data>(.*?)</script>', page, re.S)[1])
        self.assertEqual(list(struct.unpack("<12I", base64.b64decode(data["triangles"]))), [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3])
        self.assertEqual(data["t"], [0.0, 0.1, 0.2, 0.3])
        top = struct.unpack("<12H", base64.b64decode(data["x"][1]))[11]  # height of the last node
        self.assertAlmostEqual(data["low"][2] + data["step"] * top, 0.045, 5)
        samples = struct.unpack("<15000f", base64.b64decode(data["tools"][0]["samples"]))
        self.assertAlmostEqual(samples[15 * 999], 1.0, 6)  # the last tick's time
        self.assertEqual({samples[15 * i + 10] for i in range(1000)}, {0.0, 1.0, 3.0})  # free, stick, frictional slide

    @unittest.skipUnless(HAS_MATPLOTLIB and HAS_PLAYER, "needs matplotlib and libjs-three")
    def test_a_film_of_a_run_that_touches_nothing_is_played(self):
        write_trace(self.folder)
        with open(os.path.join(self.folder, "trace.csv")) as file:
            free = file.read().splitlines()[:90]
        with open(os.path.join(self.folder, "trace.csv"), "w") as file:
            file.write("\n".join(free))
        write_view(self.folder, film=4, frames=0)
        self.run_script(self.folder)
        self.assertIn("id=player-data", self.page())

    @unittest.skipUnless(HAS_MATPLOTLIB and HAS_PLAYER, "needs matplotlib and libjs-three")
    def test_a_film_that_is_too_large_is_thinned_and_says_so(self):
        write_trace(self.folder)
        write_view(self.folder, film=1500, nodes=1000)
        self.run_script(self.folder)
        page = self.page()
        self.assertLess(len(page), 5.1e6)
        self.assert_has(page, "Frames were left out to keep the page small")

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_parts_of_a_result_give_parts_of_a_report(self):
        for make in (write_trace, write_summary, write_view):
            folder = self.sub(make.__name__)
            make(folder)
            self.run_script(folder)
            self.assertIn("</html>", self.page(folder=folder))

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
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

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_point_tools_and_single_frames_are_drawn(self):
        write_view(self.folder, shape="point", frames=1)
        self.run_script(self.folder)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "mesh.png")))

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_a_close_up_shows_what_hangs_together(self):
        """A strip of triangles that leaves the box and comes back: the far piece is a loose fragment and is left out."""
        sys.path.insert(0, os.path.join(ROOT, "scripts"))
        self.addCleanup(sys.path.remove, os.path.join(ROOT, "scripts"))
        import numpy as np
        from report_parts.surface_picture import joined_to
        strip = np.array([[i, i + 1, i + 2] for i in range(30)])
        inside = np.array([i < 12 or i > 20 for i in range(30)])
        self.assertEqual(np.flatnonzero(joined_to(strip, inside, 5)).tolist(), list(range(12)))
        self.assertEqual(np.flatnonzero(joined_to(strip, inside, 25)).tolist(), list(range(21, 30)))
        shuffled = np.random.default_rng(1).permutation(30)
        found = joined_to(strip[shuffled], inside[shuffled], int(np.flatnonzero(shuffled == 5)[0]))
        self.assertEqual(sorted(shuffled[found].tolist()), list(range(12)))

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
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

    def test_colours_of_the_palette_are_told_apart_on_white_and_on_black(self):
        import re
        with open(os.path.join(os.path.dirname(os.path.dirname(SCRIPT)), "view", "page", "palette.css"), encoding="utf-8") as file:
            white, black = file.read().split("@media")
        read = lambda text: dict(re.findall(r"--([\w-]+): (#[0-9A-F]{6});", text))
        for found in (read(white), {**read(white), **read(black)}):
            rgb = {name: [int(found[name][i:i + 2], 16) for i in (1, 3, 5)] for name in ("normal", "tangential", "force", "limit", "stick", "frictional_slide")}
            for one in rgb:
                for other in rgb:
                    if one < other:
                        self.assertGreater(sum((a - b) ** 2 for a, b in zip(rgb[one], rgb[other])) ** 0.5, 60, (one, other))

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_runs_are_compared(self):
        for name, rows in (("one", 1000), ("two", 500)):
            write_trace(self.sub(name), rows=rows)
            write_summary(self.sub(name))
        one = {"run": "two", "against": "one", "seconds": 0.5, "rms_n": 0.01, "rms_share": 0.2, "largest_n": 0.03, "largest_share": 0.4, "largest_at_s": 0.3, "beyond_7_percent": 0.5,
               "beyond_10_percent": 0.4, "tools_apart_m": 0.002, "same_bits": False, "noticed": "yes"}
        with open(os.path.join(self.folder, "compare.json"), "w") as file:
            json.dump({"runs": [{"name": name, "folder": self.sub(name), "scene": "a <slab>", "hash": ""} for name in ("one", "two")],
                       "settings": [{"key": "contact.mu", "values": [0.5, None]}], "forces": [one]}, file)
        self.run_script("--compare", self.folder)
        page = self.page("compare.html")
        self.assert_stands_alone(page)
        for words in ("<h1>one and two compared</h1>", "a &lt;slab&gt;", "<th class=number>two</th>", "<td>0.5</td><td>not set</td>", "would a person notice?</b> <span class=word>yes", "2.00 mm apart"):
            self.assert_has(page, words)
        if HAS_CHARTS:
            charts = self.specs(page)
            self.assertEqual([c["title"] for c in charts], ["Normal force", "How far the forces are apart", "Tangential force"])
            self.assertEqual({c["group"] for c in charts}, {"time"})  # one cursor
            self.assertEqual([len(s["x"]) for s in charts[0]["series"]], [1000, 500])
            self.assertEqual(charts[0]["x"]["max"], 1.0)

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_paper_page_shows_claims_and_laws(self):
        for law in ("slide", "stick", "stick_slip", "coulomb_slide", "coulomb"):
            write_trace(self.sub(law), law=law)
        with open(os.path.join(self.folder, "paper.json"), "w") as file:
            json.dump({"claims": [{"text": "no friction", "value": 1e-17, "bound": 1e-12, "holds": True},
                                  {"text": "no buzz", "value": 1.0000001, "bound": 1, "holds": False}],
                       "table": [{"law": "paper_stick_slip", "metric": "identity", "buzz": 0.3, "crossing_jump": 2.5}]}, file)
        self.run_script("--paper", self.folder)
        page = self.page("paper.html")
        for words in ("1 of 2 claims hold", "1.0000001", "✗ does not hold", "250 %"):
            self.assert_has(page, words)
        if HAS_CHARTS:
            self.assertEqual([c["title"] for c in self.specs(page)], ["Pure sliding (figure 3)", "Pure sticking (figure 4)", "Stick-slip, µ = 1 (figure 5)", "One transition of stick-slip",
                                                                      "Normal force, µ = 0: the chatter", "Normal force, µ = 1"])

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_paper_page_with_one_experiment(self):
        write_trace(self.sub("stick"), law="stick")
        self.run_script("--paper", self.folder)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "paper.png")))

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_ten_thousand_rows_take_seconds(self):
        write_trace(self.folder, rows=10000)
        write_summary(self.folder)
        write_view(self.folder, frames=4)
        start = os.times().user
        self.run_script(self.folder)
        self.assertLess(os.times().user - start, 6.0)

    def test_without_matplotlib_the_numbers_stay(self):
        fake = self.sub("fake")
        with open(os.path.join(fake, "matplotlib.py"), "w") as file:
            file.write("raise ImportError('hidden')\n")
        write_trace(self.folder)
        write_summary(self.folder)
        words = self.run_script(self.folder, status=3, quiet=False, PYTHONPATH=fake)
        self.assertIn("python3-matplotlib", words)
        self.assert_has(self.page(), "0.0123 N")

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_without_jinja_the_pictures_stay(self):
        fake = self.sub("fake")
        with open(os.path.join(fake, "jinja2.py"), "w") as file:
            file.write("raise ImportError('hidden')\n")
        write_trace(self.folder)
        write_summary(self.folder)
        words = self.run_script(self.folder, status=3, quiet=False, PYTHONPATH=fake)
        self.assertEqual(words, f"report.py: no page: Jinja2 is missing (Debian: python3-jinja2); the numbers are in {self.folder}\n")
        self.assertTrue(os.path.exists(os.path.join(self.folder, "force.png")))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "report.html")))

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
        from report_parts import notices, pages
        for name, holder in (("Chart.js", "Chart.js Contributors"), ("three.js", "three.js authors")):
            text = notices.with_notice(name, "let a = 1;")
            self.assertTrue(text.startswith("/*!") and text.endswith("*/\nlet a = 1;"))
            self.assertIn(holder, text)
            self.assertIn("The above copyright notice and this permission notice shall be included", text)
            self.assertEqual(text.count("*/"), 1)
            script = pages.library(name)
            self.assertEqual(script.count("Permission is hereby granted"), 1 if script else 0)
            self.assertNotRegex(script, "</script|<!--")

    def test_the_page_begins_with_real_time_and_trust(self):
        write_summary(self.folder, real_time={"keeps": "no", "told": "no: a refresh takes 61 ms of 33.3 (reduce 55)"}, notes=["the body <floats>"],
                      trust={"trustworthy": False, "reasons": [{"what": "jumps of 60 % at <edges>", "cure": "set contact.surface to loop"}]})
        in_this_process([self.folder], {})
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
