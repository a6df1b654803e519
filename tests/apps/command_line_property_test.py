#!/usr/bin/python3
"""The command line as other programs rely on it: commands, exit codes, files, keys. KILOTOUCH names the program."""
import csv
import json
import math
import os
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
MESHES = os.path.join(ROOT, "meshes")
SCENE = os.path.join(ROOT, "scenes", "organ_springs.json")
SHORT = ["--set", "duration=0.4", "--set", "tool.path.press_drag.press_time=0.1"]
# Auto certifies eight local models first; a block of a hundred nodes in place of the organ.
QUICK = [*SHORT, "--set", "local.reducer=condensed", "--set", "object.mesh=" + os.path.join(MESHES, "pad.off")]

COMMANDS = ["run", "paper", "replay", "compare", "advise", "chart", "list", "mesh info", "mesh repair", "mesh tet", "stability"]
COLUMNS = ("t,tool_x,tool_y,tool_z,force_x,force_y,force_z,f_n,f_t,mode,triangle,toi,gap,model_frame,step_us,"
           "torque_x,torque_y,torque_z,normal_x,normal_y,normal_z,model_force_x,model_force_y,model_force_z,indentation").split(",")
SUMMARY = {  # key -> keys inside; None: a value
    "scene": None, "seed": None, "hash": None,
    "model": ["type", "material", "nodes", "tets", "springs", "triangles"],
    "local": ["reducer", "dof", "patch_vertices", "certified_error", "reason"],
    "force": ["mean_n", "max_n", "mean_t", "max_t", "max_t_over_mu_n", "felt_t_over_mu_n", "buzz", "crossing_jump", "refresh_jump"],
    "ticks": ["free", "stick", "slide", "frictional_slide", "total"],
    "crossings": None, "lost_contacts": None, "missed_impacts": None, "free_ticks_inside": None,
    "edge_ticks": None, "went_through": None, "contact_lost": None, "penetration_max_m": None, "energy_min_j": None,
    "contact_solver": ["unsolved_ticks", "residual_max"],
    "step_us": ["p50", "p99", "p999", "max"], "global_ms": ["p50", "p99", "max"], "refresh_ms": ["p50", "p99"],
    "tick_period_share": ["p50", "p99"], "deadline_misses": None, "allocations_per_tick": None, "warnings": None, "notes": None, "mesh_at_contact": None,
    "real_time": ["holds", "keeps", "slow_part", "refresh_budget_ms", "refresh_ms_p50", "refresh_hz", "tick_share", "cure", "told"],
    "trust": ["trustworthy", "reasons"],
}
HAS_MATPLOTLIB = subprocess.run(["/usr/bin/python3", "-c", "import numpy, matplotlib"], capture_output=True).returncode == 0


def load(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return json.load(file)


class CommandLine(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.addCleanup(self.temporary.cleanup)
        self.folder = self.temporary.name

    def path(self, *name):
        return os.path.join(self.folder, *name)

    def kilotouch(self, *arguments, status=0):
        """Standard output; what is not a terminal gets no progress bar, but a line where it takes long, and no error no line on
        stderr but warnings."""
        result = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(result.returncode, status, result.stdout + result.stderr)
        if status == 0:
            expected = r"kilotouch: warning: object\.mesh: cells of|.*: \d+ %, \d+ s so far$"
            self.assertEqual([line for line in result.stderr.splitlines() if not re.match(expected, line)], [])
        return result.stdout

    def assert_complete(self, out):
        """Every file of a run, with the keys and columns of the contract."""
        summary = load(out, "summary.json")
        for key, inside in SUMMARY.items():
            self.assertIn(key, summary)
            for inner in inside or []:
                self.assertIn(inner, summary[key], key)
        with open(os.path.join(out, "trace.csv"), newline="", encoding="utf-8") as file:
            rows = list(csv.reader(file))
        self.assertEqual(rows[0], COLUMNS)
        self.assertEqual(len(rows) - 1, summary["ticks"]["total"])
        self.assertEqual({len(row) for row in rows}, {len(COLUMNS)})
        return summary

    def test_every_command_has_help_with_an_example(self):
        for command in COMMANDS:
            with self.subTest(command):
                self.assertIn("Example", self.kilotouch(*command.split(), "--help"))

    def test_help_names_every_command(self):
        text = self.kilotouch("--help")
        for command in COMMANDS:
            self.assertIn(command.split()[0], text)

    def test_list_as_text_and_as_json(self):
        text = self.kilotouch("list", "--json", "list.json")
        families = load(self.path("list.json"))
        self.assertIn("coulomb", [b["name"] for b in families["contact.law"]])
        for family in families.values():
            for backend in family:
                self.assertIn(backend["name"], text)
                if not backend["available"]:
                    self.assertIn(backend["option"], text)

    @unittest.skipUnless(HAS_MATPLOTLIB, "needs matplotlib")
    def test_run_writes_pictures_and_report(self):
        self.kilotouch("run", os.path.join(ROOT, "scenes", "slab_drag.json"), *QUICK, "--out", "out")
        for name in ("force.png", "report.html"):
            self.assertGreater(os.path.getsize(self.path("out", name)), 10000, name)

    def test_run_takes_settings_and_writes_the_contract(self):
        self.kilotouch("run", SCENE, *SHORT, "--set", "contact.mu=0.25", "--no-report", "--out", "deep/out", "--json", "s.json")
        summary = self.assert_complete(self.path("deep", "out"))
        self.assertEqual(summary, load(self.path("s.json")))
        self.assertEqual(summary["ticks"]["total"], 400)
        self.assertEqual(summary["settings"]["contact"]["mu_static"], 0.25)
        self.assertGreater(summary["force"]["mean_n"], 0)
        self.assertLessEqual(summary["force"]["max_t_over_mu_n"], 1 + 1e-9)

    def test_reference_is_computed_compared_and_used_again(self):
        scene = [os.path.join(ROOT, "scenes", "paper_stick_slip.json"), *SHORT, "--set", "duration=0.2"]
        out = self.kilotouch("run", *scene, "--reference", "--reference-rate", "2000", "--no-report", "--out", "a")
        self.assertIn("force error", out)
        reference = self.assert_complete(self.path("a"))["reference"]
        self.assertGreater(reference["force_error"], 0)
        self.assertTrue(0 <= reference["jnd_fraction"] <= 1)
        self.assertEqual(reference["rate_hz"], 2000)
        with open(self.path("a", "reference.csv"), encoding="utf-8") as file:
            self.assertEqual(len([line for line in file if line[0] != "#"]), 201)
        known = ["--reference-file", self.path("a", "reference.csv"), "--no-report"]
        self.kilotouch("run", *scene, *known, "--out", "b")
        self.assertEqual(load(self.path("b", "summary.json"))["reference"], reference)
        self.kilotouch("run", *scene, *known, "--set", "local.rings=3", "--out", "c")
        self.assertNotEqual(load(self.path("c", "summary.json"))["reference"]["force_error"], reference["force_error"])
        self.kilotouch("run", *scene, *known, "--set", "contact.mu=0.3", "--out", "d", status=2)
        self.assertFalse(os.path.exists(self.path("d")))
        self.kilotouch("run", *scene, "--no-report", "--out", "b")  # the old reference goes with the old run
        self.assertNotIn("reference", load(self.path("b", "summary.json")))
        self.assertFalse(os.path.exists(self.path("b", "reference.csv")))

    def test_a_lost_contact_is_said_and_ends_with_1(self):
        """Above the body in one tick, below it in the next."""
        path = [[0, 0.03, 0.026, 0.2], [0.05, 0.03, 0.026, 0.2], [0.0505, 0.03, 0.026, -0.2], [0.1, 0.03, 0.026, -0.2]]
        scene = {"duration": 0.1, "object": {"mesh": os.path.join(MESHES, "block.msh")}, "local": {"reducer": "condensed"},
                 "tool": {"shape": "sphere", "radius": 0.006, "path": {"waypoints": path}}}
        with open(self.path("leap.json"), "w", encoding="utf-8") as file:
            json.dump(scene, file)
        run = subprocess.run([PROGRAM, "run", "leap.json", "--no-report", "--out", "o"], cwd=self.folder, capture_output=True,
                             text=True, timeout=PATIENCE)
        summary = load(self.path("o", "summary.json"))
        self.assertEqual(run.returncode, 1, run.stdout + run.stderr)
        self.assertTrue(summary["contact_lost"])
        self.assertGreater(summary["missed_impacts"], 0)
        self.assertIn("most of all in tick 50 (t = 0.051 s) with 400 m/s, 0.4 m in one tick", run.stdout)

    def test_the_first_lines_say_force_real_time_and_trust_and_the_rest_is_behind(self):
        run = ["run", SCENE, *QUICK, "--no-report", "--out", "out"]
        words = self.kilotouch(*run)
        names = [line.split()[0] for line in words.splitlines()[1:4]]
        self.assertEqual(names, ["force", "real", "trustworthy"], words)
        summary = load(self.path("out", "summary.json"))
        self.assertIn(summary["real_time"]["told"], words)
        self.assertIn(summary["real_time"]["slow_part"], ["global step", "linearize", "reduce", "refine", "certify", "prepare", "haptic tick"])
        self.assertEqual(summary["real_time"]["holds"], summary["real_time"]["keeps"] != "no")
        self.assertEqual(summary["trust"]["trustworthy"], not summary["trust"]["reasons"])
        for reason in summary["trust"]["reasons"]:
            self.assertIn(reason["what"], words)
            self.assertIn(reason["cure"] or "", words)
        self.assertIn("one unit of the mesh file is", words)
        self.assertNotIn("haptic step", words)
        details = self.kilotouch(*run, "--details")
        for name in ("local model", "steadiness", "ticks", "haptic step", "refresh", "hash"):
            self.assertIn(f"\n  {name} ", details)

    def test_a_jump_at_an_edge_is_no_reason_to_trust_and_names_its_cure(self):
        words = self.kilotouch("run", os.path.join(ROOT, "scenes", "paper_stick.json"), *SHORT, "--no-report", "--out", "out")
        self.assertGreater(load(self.path("out", "summary.json"))["force"]["crossing_jump"], 0.1)
        self.assertIn("trustworthy   no", words)
        self.assertIn("in one tick at an edge of the mesh\n      cure: ", words)

    def test_every_shipped_scene_runs_to_a_force_that_a_hand_would_give(self):
        scenes = os.path.join(ROOT, "scenes")
        for name in sorted(os.listdir(scenes)):
            if name == "organ_device.json" or not name.endswith(".json"):  # that one needs a device; a folder has its own
                continue
            with self.subTest(name):
                result = subprocess.run([PROGRAM, "run", os.path.join(scenes, name), "--set", "duration=0.45", "--no-report", "--out", name],
                                        cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                self.assertLess(load(self.path(name, "summary.json"))["force"]["max_n"], 5)

    def test_units_are_warned_of_with_the_likely_scale(self):
        with open(os.path.join(MESHES, "sphere.off"), encoding="utf-8") as file:
            lines = [line for line in file.read().split("\n") if not line.startswith("#")]
        for i in range(2, 2 + int(lines[1].split()[0])):
            lines[i] = " ".join(str(1000 * float(c)) for c in lines[i].split())
        with open(self.path("mm.off"), "w", encoding="utf-8") as file:
            file.write("\n".join(lines))
        with open(self.path("mm.json"), "w", encoding="utf-8") as file:
            json.dump({"object": {"mesh": "mm.off", "model": {"young": 10}}, "duration": 0.02,
                       "tool": {"path": {"waypoints": [[0, 0, 0, 1000], [1, 0, 0, 1000]]}}}, file)
        result = subprocess.run([PROGRAM, "run", "mm.json", "--set", "local.reducer=wall", "--no-report", "--out", "out"],
                                cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("set object.scale to 0.001: its unit is likely mm", result.stderr)
        self.assertIn("object.model.young: 10 Pa is outside 100 to 1e+09 Pa", result.stderr)
        self.assertIn("never touched the body", result.stdout)

    def test_json_on_standard_output_is_json_alone(self):
        families = json.loads(self.kilotouch_out("list", "--json", "-"))
        self.assertIn("contact.law", families)
        info = json.loads(self.kilotouch_out("mesh", "info", os.path.join(MESHES, "sphere.off"), "--json", "-", "--quiet"))
        self.assertEqual(info["report"]["triangles"], 1280)
        summary = json.loads(self.kilotouch_out("run", SCENE, *QUICK, "--no-report", "--out", "out", "--json", "-"))
        self.assertEqual(summary, load(self.path("out", "summary.json")))
        self.assertFalse(os.path.exists(self.path("-")))

    def kilotouch_out(self, *arguments):
        result = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout

    def test_quiet_says_nothing_and_version_has_a_short_form(self):
        self.assertEqual(self.kilotouch("run", SCENE, *QUICK, "--no-report", "--out", "out", "--quiet"), "")
        self.assertGreater(load(self.path("out", "summary.json"))["force"]["mean_n"], 0)
        self.assertEqual(self.kilotouch("list", "-q"), "")
        self.assertEqual(self.kilotouch("-V"), self.kilotouch("--version"))

    def test_the_version_names_the_licence_of_what_is_linked(self):
        linked = subprocess.run(["ldd", PROGRAM], capture_output=True, text=True, check=True).stdout
        parts = [name for name, library in (("CGAL", "libgmp"), ("CHOLMOD", "libcholmod")) if library in linked]
        licence = self.kilotouch("--version").splitlines()[1].removeprefix("licence of this build: ")
        if parts:
            self.assertTrue(licence.startswith(f"GPL-3.0-or-later, with {' and '.join(parts)} ("), licence)
        else:
            self.assertEqual(licence, "Apache-2.0")

    def test_man_page_and_completions_have_every_option(self):
        made = subprocess.run([os.path.join(ROOT, "scripts", "command_line_files"), "--check", "--program", PROGRAM], capture_output=True, text=True)
        self.assertEqual(made.returncode, 0, made.stderr)
        with open(os.path.join(ROOT, "docs", "kilotouch.1"), encoding="utf-8") as file:
            sections = file.read().replace("\\-", "-").split("\n.SS ")
        for command in [*COMMANDS, "check"]:
            section = next(part for part in sections if part.split("\n")[0] == f"kilotouch {command}")
            options = re.findall(r"(?m)^  (?:-\w,)?(--[\w-]+)", self.kilotouch(*command.split(), "--help"))
            self.assertIn("--help", options)
            for option in options:
                self.assertIn(option, section, command)
        shell = (f"source {ROOT}/scripts/completion/kilotouch; COMP_WORDS=(kilotouch mesh rep); COMP_CWORD=2; _kilotouch; echo ${{COMPREPLY[@]}}; "
                 "COMP_WORDS=(kilotouch run --ref); COMP_CWORD=2; _kilotouch; echo ${COMPREPLY[@]}")
        completed = subprocess.run(["bash", "-c", shell], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(completed.stdout.split("\n")[:2], ["repair", "--reference --reference-file --reference-rate"], completed.stderr)

    def test_an_error_of_set_up_names_file_and_key(self):
        result = subprocess.run([PROGRAM, "run", SCENE, "--set", "tool.path.press_drag.at=[5,5]", "--out", "out"], cwd=self.folder,
                                capture_output=True, text=True, timeout=PATIENCE)
        self.assertEqual(result.returncode, 2)
        self.assertIn("organ_springs.json: tool.path.press_drag.at: ", result.stderr)

    def test_a_mesh_needs_no_scene(self):
        self.kilotouch("run", os.path.join(MESHES, "sphere.off"), *SHORT, "--set", "local.reducer=condensed", "--no-report", "--out", "out")
        summary = self.assert_complete(self.path("out"))
        self.assertGreater(summary["model"]["tets"] + summary["model"]["springs"], 0)
        self.assertGreater(summary["force"]["mean_n"], 0)
        self.kilotouch("drag", os.path.join(MESHES, "sphere.off"), *SHORT, "--set", "local.reducer=condensed", "--no-report", "--out", "drag")
        self.assertEqual(load(self.path("drag", "summary.json"))["hash"], summary["hash"])  # its former word

    def test_a_surface_alone_becomes_a_lattice_and_tetrahedra_stay(self):
        ball, block = os.path.join(MESHES, "sphere.off"), os.path.join(MESHES, "block.msh")
        for mesh, settings, body, model in ((ball, [], "lattice", "fem"),
                                            (ball, ["object.body=mesh"], "mesh", "msd"),
                                            (ball, ["object.model.type=msd"], "lattice", "msd"),
                                            (ball, ["contact.surface=loop"], "mesh", "fem"),
                                            (block, [], "mesh", "msd"),
                                            (block, ["object.body=lattice"], "lattice", "fem")):
            given = [word for setting in ("duration=0.05", "local.reducer=condensed", *settings) for word in ("--set", setting)]
            self.kilotouch("run", mesh, *given, "--no-report", "--force", "--out", "out")
            summary = load(self.path("out", "summary.json"))
            self.assertEqual((summary["settings"]["object"]["body"], summary["model"]["type"]), (body, model), settings)
            self.assertEqual(summary["model"]["parameters"].get("nodes_per_element", 4), 4)

    def test_a_surface_that_would_lock_or_bend_too_little_gets_cubes(self):
        for settings, per_cell in (([], 4), (["object.model.poisson=0.46"], 10),
                                   (["object.model.poisson=0.46", "object.model.element=tet4"], 4), (["object.lattice.nodes=60"], 8)):
            given = [word for setting in ("duration=0.05", "local.reducer=condensed", *settings) for word in ("--set", setting)]
            self.kilotouch("run", os.path.join(MESHES, "sphere.off"), *given, "--no-report", "--force", "--out", "out")
            summary = load(self.path("out", "summary.json"))
            self.assertEqual(summary["model"]["parameters"]["nodes_per_element"], per_cell, settings)
            self.assertEqual(any("element auto" in line for line in summary["notes"]), per_cell > 4, summary["notes"])

    def test_runs_and_replays_are_equal(self):
        for out in ("one", "two"):
            self.kilotouch("run", SCENE, *QUICK, "--no-report", "--out", out)
        self.assertEqual(load(self.path("one", "summary.json"))["hash"], load(self.path("two", "summary.json"))["hash"])
        self.assertIn("bit for bit", self.kilotouch("replay", "one", "--out", "again"))
        self.assert_same_figures("one", "again")
        self.assertIn("bit for bit", self.kilotouch("run", "again", "--no-report", "--out", "by_run"))
        self.kilotouch("run", "again", "--set", "contact.mu=1", status=2)  # no longer what was recorded
        session = load(self.path("one", "session.json"))
        session["scene"]["contact"]["mu_kinetic"] = 0.1
        with open(self.path("one", "session.json"), "w", encoding="utf-8") as file:
            json.dump(session, file)
        self.assertIn("DIFFERS", self.kilotouch("replay", "one", status=1))

    def assert_same_figures(self, run, replay):
        """All of a run's summary but its times."""
        run, replay = load(self.path(run, "summary.json")), load(self.path(replay, "summary.json"))
        timed = {"command", "step_us", "global_ms", "refresh_ms", "refresh_parts_ms", "cpu", "real_time", "deadline_misses",
                 "tick_period_share", "allocations_per_tick"}
        def without_cures(value):  # which rate a cure names, and what it costs, is by the clock
            if isinstance(value, dict):
                return {key: without_cures(inner) for key, inner in value.items() if key not in ("cure", "cures")}
            if isinstance(value, list):
                return [without_cures(inner) for inner in value]
            return value
        for summary in (run, replay):
            summary["warnings"] = [line.split("; ")[0] for line in summary["warnings"]]  # "WARNING; CURE"
        for key in run.keys() - timed:
            self.assertEqual(without_cures(run[key]), without_cures(replay[key]), key)

    def test_ticks_of_a_quarter_and_of_ten_kilohertz(self):
        """From 250 Hz to 10 kHz: as many ticks as asked for, a force, and what share of its period one takes."""
        for rate in (250, 10000):
            out = self.path(f"rate_{rate}")
            self.kilotouch("run", SCENE, *QUICK, "--set", f"local.rate_hz={rate}",
                           "--out", out, "--no-report")
            summary = load(out, "summary.json")
            self.assertEqual(summary["ticks"]["total"], round(0.4 * rate))
            self.assertGreater(summary["force"]["mean_n"], 0)
            self.assertEqual(summary["missed_impacts"], 0)
            for rank in ("p50", "p99"):
                share = summary["tick_period_share"][rank]
                self.assertAlmostEqual(share, summary["step_us"][rank] * rate / 1e6, delta=1e-9 * share)
            with open(os.path.join(out, "trace.csv"), encoding="utf-8") as file:
                times = sorted(float(row["step_us"]) for row in csv.DictReader(file))
            self.assertAlmostEqual(summary["tick_period_share"]["p50"], 1e-6 * rate * times[len(times) // 2],
                                   delta=0.05 * summary["tick_period_share"]["p50"])

    def test_the_written_force_is_the_recorded_one_and_replays(self):
        """A hand that presses harder than its device can push back, and passivity control that works on what is left."""
        hand = {"stiffness": 3000, "damping": 5, "target": [[0, 0.025, 0.025, 0.025], [0.05, 0.025, 0.025, 0.005]]}
        scene = {"duration": 0.1, "object": {"mesh": os.path.join(MESHES, "pad.off"), "model": {"young": 1e6},
                                             "layers": {"count": 1, "thickness": 0.001}},
                 "tool": {"radius": 0.004, "path": {"hand": hand}}, "local": {"passivity_damping": 20}}
        with open(self.path("hand.json"), "w", encoding="utf-8") as file:
            json.dump(scene, file)
        # A limit cycle is predicted, on standard error.
        for arguments in (["run", "hand.json", "--no-report", "--out", "run"], ["replay", "run", "--out", "again"]):
            result = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True, timeout=PATIENCE)
            self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assert_same_figures("run", "again")
        with open(self.path("run", "trace.csv"), newline="", encoding="utf-8") as file:
            rows = [{key: float(value) for key, value in row.items() if key != "mode"} for row in csv.DictReader(file)]
        def size(row, name):
            return math.hypot(*(row[f"{name}_{axis}"] for axis in "xyz"))
        self.assertLessEqual(max(size(row, "force") for row in rows), 7.9)
        self.assertGreater(max(size(row, "model_force") for row in rows), 8)
        work = least = 0
        for before, row in zip(rows, rows[1:]):
            work -= sum(row["force_" + axis] * (row["tool_" + axis] - before["tool_" + axis]) for axis in "xyz")
            least = min(least, work)
        self.assertAlmostEqual(load(self.path("run", "summary.json"))["energy_min_j"], least, places=12)

    def test_interrupt_keeps_what_was_recorded(self):
        for wait in (0.2, 1, 5, 20):  # [s] on a busy machine it may still prepare the first model: that leaves nothing
            process = subprocess.Popen([PROGRAM, "run", SCENE, "--set", "duration=300", "--set", "local.reducer=condensed", "--no-report", "--out", "out"],
                                       cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.addCleanup(process.kill)
            while not os.path.isdir(self.path("out")) and process.poll() is None:
                time.sleep(0.01)  # the folder is made when the run begins
            time.sleep(wait)
            process.send_signal(signal.SIGINT)
            process.wait(timeout=PATIENCE)
            self.assertEqual(process.returncode, 130)
            if os.path.exists(self.path("out", "summary.json")):
                break
            shutil.rmtree(self.path("out"))
        summary = self.assert_complete(self.path("out"))
        self.assertTrue(any("stopped early" in warning for warning in summary["warnings"]), summary["warnings"])

    def test_mesh_info_finds_faults(self):
        good = self.kilotouch("mesh", "info", os.path.join(MESHES, "sphere.off"), "--json", "good.json")
        self.assertIn("no defects found", good)
        bad = self.kilotouch("mesh", "info", os.path.join(MESHES, "broken", "open.off"), "--json", "bad.json")
        self.assertNotIn("no defects found", bad)
        self.assertNotEqual(load(self.path("good.json"))["report"], load(self.path("bad.json"))["report"])

    def test_mesh_repair_turns_a_surface_outward(self):
        self.kilotouch("mesh", "repair", os.path.join(MESHES, "broken", "inside_out.off"), "-o", "fixed.off")
        self.assertIn("no defects found", self.kilotouch("mesh", "info", "fixed.off"))

    def test_mesh_repair_offers_the_tolerance_that_joins_rounded_corners(self):
        with open(os.path.join(MESHES, "sphere.off"), encoding="ascii") as file:
            words = [w for line in file if not line.startswith("#") for w in line.split()]
        nodes, faces = int(words[1]), int(words[2])
        x = [[float(v) for v in words[4 + 3 * i:7 + 3 * i]] for i in range(nodes)]
        corner = [[int(i) for i in words[5 + 3 * nodes + 4 * f:8 + 3 * nodes + 4 * f]] for f in range(faces)]
        with open(self.path("rounded.stl"), "w", encoding="ascii") as file:
            file.write("solid\n")
            for f, triangle in enumerate(corner):  # every triangle rounded a little differently
                file.write("facet normal 0 0 0\nouter loop\n")
                for i in triangle:
                    file.write("vertex " + " ".join(f"{v + 1e-8 * (f % 3):.9f}" for v in x[i]) + "\n")
                file.write("endloop\nendfacet\n")
            file.write("endsolid\n")
        offer = re.search(r"mesh repair --weld (\S+) joins them \(open edges (\d+) -> 0\)",
                          self.kilotouch("mesh", "repair", "rounded.stl", "-o", "pieces.off", "--json", "offer.json"))
        self.assertTrue(offer)
        self.assertEqual(load(self.path("offer.json"))["weld"]["tolerance"], float(offer[1]))
        self.assertLess(float(offer[1]), 1e-6)
        told = self.kilotouch("mesh", "repair", "rounded.stl", "--weld", offer[1], "-o", "whole.off", "--json", "whole.json")
        self.assertIn("no defects left", told)
        self.assertEqual(load(self.path("whole.json"))["report"]["triangles"], faces)

    def test_mesh_tet_fills_a_surface_in_every_format(self):
        if not any(b["available"] for b in self.tetrahedralizers()):
            self.skipTest("no tetrahedralizer is in this build")
        self.kilotouch("mesh", "tet", os.path.join(MESHES, "sphere.off"), "-o", "ball.vtu", "--json", "tet.json")
        result = load(self.path("tet.json"))
        self.assertGreater(result["tetrahedra"], 100)
        self.assertAlmostEqual(result["volume"] / result["surface_volume"], 1, places=9)
        for extension in ("obj", "off", "ply", "stl", "msh", "vtu"):
            with self.subTest(extension):
                self.kilotouch("mesh", "repair", os.path.join(MESHES, "sphere.off"), "-o", "ball." + extension)
                self.kilotouch("mesh", "info", "ball." + extension, "--json", "info.json")
                self.assertEqual(load(self.path("info.json"))["report"]["triangles"], 1280)

    def tetrahedralizers(self):
        self.kilotouch("list", "--json", "list.json")
        return load(self.path("list.json"))["object.tetrahedralize.backend"]


if __name__ == "__main__":
    unittest.main()
