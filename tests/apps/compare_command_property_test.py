#!/usr/bin/python3
"""kilotouch compare: on traces whose difference is known in closed form, and on runs. KILOTOUCH names the program."""
import json
import math
import os
import subprocess
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
SCENE = {"title": "a drag", "contact": {"mu": 0.5}, "object": {"mesh": "ball.off"}}


class Compare(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def kilotouch(self, *arguments, status=0):
        result = subprocess.run([PROGRAM, *arguments], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(result.returncode, status, result.stderr[-2000:])
        return result

    def write_run(self, name, force, ticks=1000, h=0.001, scene=SCENE, tool=lambda t: (0, 0, 0)):
        """A result folder whose force on the tool is a function of time."""
        os.makedirs(self.path(name))
        with open(self.path(name, "trace.csv"), "w") as file:
            file.write("t,tool_x,tool_y,tool_z,force_x,force_y,force_z,f_n,f_t,mode,triangle,toi,gap,model_frame,step_us\n")
            for i in range(1, ticks + 1):
                t = i * h
                f, x = force(t), tool(t)
                file.write(",".join(repr(v) for v in (t, *x, *f, abs(f[2]), abs(f[0]))) + ",stick,0,0,0,0,10\n")
        for file_name, content in (("scene.json", scene), ("summary.json", {"hash": name})):
            with open(self.path(name, file_name), "w") as file:
                json.dump(content, file)
        return self.path(name)

    def compared(self, *runs):
        out = self.kilotouch("compare", *runs, "--no-report", "--json", "c.json").stdout
        with open(self.path("c.json")) as file:
            made = json.load(file)
        with open(self.path("out", "compare", "compare.json")) as file:
            self.assertEqual(json.load(file), made)
        return made, out

    def test_differences_are_those_of_the_formulas(self):
        """F = (0, 0, 2) against the same with 0.3 sin over whole periods: RMS 0.3 / sqrt 2, largest 0.3 at a quarter."""
        self.write_run("a", lambda t: (0, 0, 2))
        self.write_run("b", lambda t: (0.3 * math.sin(2 * math.pi * t), 0, 2))
        made, out = self.compared("a", "b")
        force = made["forces"][0]
        self.assertEqual((force["run"], force["against"]), ("b", "a"))
        self.assertAlmostEqual(force["rms_n"], 0.3 / math.sqrt(2), 12)
        self.assertAlmostEqual(force["rms_share"], 0.3 / math.sqrt(2) / 2, 12)
        self.assertAlmostEqual(force["largest_n"], 0.3, 12)
        self.assertAlmostEqual(force["largest_share"], 0.15, 12)
        self.assertAlmostEqual(force["largest_at_s"] % 0.5, 0.25, 12)
        # |sin| > s of |F| = sqrt(4 + 0.09 sin^2): sin^2 > 4 s^2 / (0.09 (1 - s^2))
        share = lambda s: 1 - 2 / math.pi * math.asin(2 * s / (0.3 * math.sqrt(1 - s * s)))
        self.assertAlmostEqual(force["beyond_7_percent"], share(0.07), delta=0.005)
        self.assertAlmostEqual(force["beyond_10_percent"], share(0.10), delta=0.005)
        self.assertEqual(force["noticed"], "yes")
        self.assertIn("noticed   yes", out)
        self.assertEqual(made["settings"], [])
        self.assertIn("settings  the same", out)

    def test_without_a_common_contact_nothing_is_judged(self):
        """A force against none, whichever is first, and forces that follow each other: no verdict, whatever their size."""
        pulse = lambda low, high: lambda t: (0, 0, 0.1 if low <= t < high else 0)
        for name, force in (("none", pulse(2, 2)), ("early", pulse(0, 0.4)), ("late", pulse(0.6, 1))):
            self.write_run(name, force)
        for first, other in (("none", "early"), ("early", "none"), ("early", "late"), ("none", "none")):
            made, out = self.compared(first, self.path(other))
            self.assertIsNone(made["forces"][0]["noticed"], (first, other))
            self.assertEqual(made["forces"][0]["common_contact_s"], 0)
            self.assertIn("noticed   not judged", out)
        self.write_run("both", pulse(0.35, 1))
        self.assertAlmostEqual(self.compared("early", "both")[0]["forces"][0]["common_contact_s"], 0.05, delta=0.0015)

    def test_settings_that_were_changed_while_it_ran_are_told(self):
        for name, changes in (("a", [[0, "contact.mu", 0.9], [250, "contact.mu", 0.5], [100, "local.reducer", "wall"]]), ("b", [[100, "local.reducer", "wall"]])):
            self.write_run(name, lambda t: (0, 0, 2))
            with open(self.path(name, "session.json"), "w") as file:
                json.dump({"setting_changes": changes}, file)
        made, out = self.compared("a", "b")
        self.assertEqual(made["settings"], [{"key": "contact.mu while it ran", "values": ["0.9 at 0 s; 0.5 at 0.25 s", None]}])
        self.assertIn('contact.mu while it ran: "0.9 at 0 s; 0.5 at 0.25 s" | not set', out)
        with open(self.path("b", "session.json"), "w") as file:
            json.dump({"setting_changes": [1]}, file)
        self.assertIn("session.json: setting_changes", self.kilotouch("compare", "a", "b", status=2).stderr)

    def test_a_person_notices_ten_percent_perhaps_seven_and_nothing_below(self):
        self.write_run("a", lambda t: (0, 0, 1))
        for name, size, noticed in (("six", 1.06, "no"), ("eight", 1.087, "perhaps"), ("twelve", 1.12, "yes"), ("less", 0.88, "yes")):
            self.write_run(name, lambda t: (0, 0, size))
            self.assertEqual(self.compared("a", name)[0]["forces"][0]["noticed"], noticed, name)
        # One tick of a thousand is told by the largest difference, but is no difference of the runs.
        self.write_run("jerk", lambda t: (0, 0, 2 if abs(t - 0.5) < 1e-9 else 1))
        force = self.compared("a", "jerk")[0]["forces"][0]
        self.assertEqual((force["noticed"], force["largest_n"]), ("no", 1))
        # Before the touch both are 0: nothing to notice, and nothing to divide by.
        self.write_run("late", lambda t: (0, 0, 0 if t < 0.5 else 1))
        self.write_run("later", lambda t: (0, 0, 0 if t < 0.5 else 1.05))
        self.assertEqual(self.compared("late", "later")[0]["forces"][0]["beyond_7_percent"], 0)
        self.write_run("never", lambda t: (0, 0, 0))
        self.assertIsNone(self.compared("never", "never")[0]["forces"][0]["noticed"])
        self.assertIsNone(self.compared("never", "a")[0]["forces"][0]["noticed"])

    def test_other_rates_and_durations_and_ways_are_told(self):
        """A line in time is the same at any rate; where one run ends, comparison does."""
        self.write_run("a", lambda t: (t, 0, 2 * t))
        self.write_run("half", lambda t: (t, 0, 2 * t), ticks=400, h=0.002, tool=lambda t: (0.003 * t, 0, 0))
        made, out = self.compared("a", "half")
        force = made["forces"][0]
        self.assertAlmostEqual(force["seconds"], 0.8, 9)
        self.assertLess(force["largest_n"], 2.3e-3)  # the first tick of the coarser one is at 2 ms
        self.assertGreater(force["largest_n"], 2.2e-3)
        self.assertEqual(force["largest_at_s"], 0.001)
        self.assertAlmostEqual(force["tools_apart_m"], 0.0024, 9)
        self.assertIn("went different ways", out)
        self.assertIn("only the first 0.8 s", out)

    def test_both_hands_are_compared(self):
        for name, sizes in (("a", (1, 2)), ("b", (1, 2.5)), ("one", (1,))):
            for k, size in enumerate(sizes):
                self.write_run(f"{name}{k}", lambda t: (0, 0, size), ticks=100)
            os.rename(self.path(name + "0"), self.path(name))
            if len(sizes) > 1:
                os.rename(self.path(name + "1", "trace.csv"), self.path(name, "trace_2.csv"))
        made, out = self.compared("a", "b", "one")
        both, alone = made["forces"]
        self.assertEqual((both["noticed"], both["second_tool"]["noticed"]), ("no", "yes"))
        self.assertAlmostEqual(both["second_tool"]["rms_share"], 0.25, 12)
        self.assertIn("second    RMS 0.5 N, 25 % of a's", out)
        self.assertNotIn("second_tool", alone)

    def test_settings_that_differ_are_listed_key_by_key(self):
        force = lambda t: (0, 0, 1)
        self.write_run("a", force)
        self.write_run("b", force, scene={**SCENE, "contact": {"mu": 0.8}, "local": {"rings": 2}})
        self.write_run("c", force, scene={**SCENE, "object": {"mesh": "other.off"}})
        made, out = self.compared("a", "b", "c")
        self.assertEqual(made["settings"], [{"key": "contact.mu", "values": [0.5, 0.8, 0.5]}, {"key": "object.mesh", "values": ["ball.off", "ball.off", "other.off"]},
                                            {"key": "local.rings", "values": [None, 2, None]}])
        self.assertIn("contact.mu: 0.5 | 0.8 | 0.5", out)
        self.assertEqual([(f["run"], f["same_bits"], f["noticed"]) for f in made["forces"]], [("b", True, "no"), ("c", True, "no")])
        self.assertIn("bit for bit", out)

    def test_a_run_against_itself_and_against_more_friction(self):
        for name, mu in (("one", 0.5), ("same", 0.5), ("rough", 0.9)):
            self.kilotouch("run", os.path.join(ROOT, "scenes", "slab_drag.json"), "--set", "duration=0.3", "--set", "object.mesh=" + os.path.join(ROOT, "meshes", "pad.off"), "--set", f"contact.mu={mu}",
                           "--no-report", "--out", name)
        made = self.compared("one", "same", "rough")[0]
        self.assertEqual([s["key"] for s in made["settings"]], ["contact.mu_static", "contact.mu_kinetic"])
        self.assertTrue(made["forces"][0]["same_bits"])
        self.assertEqual(made["runs"][0]["hash"], made["runs"][1]["hash"])
        self.assertEqual(made["forces"][1]["noticed"], "yes")
        self.assertLess(made["forces"][1]["tools_apart_m"], 1e-12)

    def test_wrong_folders_are_one_line(self):
        good = self.write_run("good", lambda t: (0, 0, 1), ticks=5)
        os.mkdir(self.path("empty"))
        for name, file, content in (("words", "trace.csv", "t,tool_x,tool_y,tool_z,force_x,force_y,force_z\n0.001,0,0,0,0,zero,1\n"), ("columns", "trace.csv", "t,force_x\n0.001,1\n"),
                                    ("cut", "scene.json", "{"), ("list", "summary.json", "[]"), ("late", "trace.csv", "t,tool_x,tool_y,tool_z,force_x,force_y,force_z\n0.001,0,0,0,0,0,1\n0.003,0,0,0,0,0,1\n")):
            self.write_run(name, lambda t: (0, 0, 1), ticks=5)
            with open(self.path(name, file), "w") as out:
                out.write(content)
        for wrong, says in ((["lost"], "lost: no such folder"), (["good/trace.csv"], "is no folder"), (["empty"], "trace.csv is missing"), (["words"], 'row 1: force_y "zero" is not a finite number'),
                            (["columns"], "no column force_y"), (["cut"], "scene.json"), (["list"], "summary.json: is no group"), (["late"], "row 2: t is 0.003"), ([], "At least 2")):
            error = self.kilotouch("compare", good, *wrong, "--out", "o", status=2).stderr
            self.assertEqual(error.count("\n"), 1, error)
            self.assertIn(says, error)
        self.assertFalse(os.path.exists(self.path("o")))


if __name__ == "__main__":
    unittest.main()
