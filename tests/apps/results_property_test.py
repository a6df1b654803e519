#!/usr/bin/python3
"""Results are not lost: places are tried before the work, folders belong to one run, files are whole and never follow links,
a session replays from anywhere with its meshes as they were. KILOTOUCH names the program."""
import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
PAD = os.path.join(ROOT, "meshes", "pad.off")
NOWHERE = "/proc/kilotouch"  # nobody can make a file there, root neither

# One layer of tetrahedra: "node" numbers from 0.
NODES = "8 3 0 0\n0 0 0 0\n1 .04 0 0\n2 .04 .04 0\n3 0 .04 0\n4 0 0 .02\n5 .04 0 .02\n6 .04 .04 .02\n7 0 .04 .02\n"
ELEMENTS = "6 4 0\n0 0 1 2 6\n1 0 2 3 6\n2 0 3 7 6\n3 0 7 4 6\n4 0 4 5 6\n5 0 5 1 6\n"
TIP = "OFF\n4 4 0\n0 0 0\n.004 0 0\n0 .004 0\n0 0 .004\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"


def digest(path):
    with open(path, "rb") as file:
        return hashlib.sha256(file.read()).hexdigest()


class Results(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = os.path.join(temporary.name, "work")
        os.mkdir(self.folder)
        shutil.copy(PAD, self.folder)
        self.write_scene("s.json")

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def write(self, name, content):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(content)

    def write_scene(self, name, **more):
        scene = {"duration": 0.06, "object": {"mesh": "pad.off", "layers": {"count": 1, "thickness": 0.001}},
                 "local": {"reducer": "condensed"}, "tool": {"path": {"press_drag": {"depth": 0.002, "press_time": 0.03}}}}
        for key, value in more.items():
            scene[key] = {**scene.get(key, {}), **value} if isinstance(value, dict) else value
        self.write(name, json.dumps(scene))

    def run_program(self, *words, cwd=None, wait=120, **more):
        return subprocess.run([PROGRAM, *words], cwd=cwd or self.folder, capture_output=True, text=True, timeout=wait, errors="replace", **more)

    def succeeds(self, *words, **more):
        out = self.run_program(*words, **more)
        self.assertEqual(out.returncode, 0, out.stdout + out.stderr)
        return out

    def refused(self, *words, says=(), **more):
        """One line, exit code 2."""
        out = self.run_program(*words, **more)
        lines = [line for line in out.stderr.splitlines() if "warning:" not in line]
        self.assertEqual((out.returncode, len(lines)), (2, 1), (words, out.stdout, out.stderr))
        for word in says:
            self.assertIn(word, lines[0])
        return lines[0]

    # --- Whether a place can be written is asked before the work.

    def test_places_are_tried_before_the_work(self):
        long = ("--set", "duration=600")  # would take minutes
        self.write("file", "in the way")
        run = ["run", "s.json", "--no-report", *long]
        library = self.path("lib")
        os.mkdir(library)
        shutil.copy(PAD, library)
        commands = [[*run, "--out"], [*run, "--out", "fine", "--json"], ["drag", "pad.off", "--no-report", *long, "--out"],
                    ["paper", *long, "--out"], ["paper", "--out", "fine", *long, "--json"], ["check", library, "--out"],
                    ["check", library, "--out", "fine", "--json"], ["chart", "--out"], ["chart", "--out", "fine", "--json"],
                    ["stability", "--out"], ["stability", "--out", "fine", "--json"], ["advise", "s.json", "--json"],
                    ["mesh", "tet", "pad.off", "--json"], ["device", "test", "--machine", "--json"], ["device", "list", "--json"],
                    ["list", "--json"], ["view", "s.json", "--port", "0", "--record"]]
        for words in commands:
            for place in (NOWHERE, self.path("file", "inside")):
                with self.subTest(" ".join(words + [place])):
                    start = time.monotonic()
                    line = self.refused(*words, place)
                    self.assertIn(place, line)
                    self.assertLess(time.monotonic() - start, 30)
                    self.assertFalse(os.path.exists(self.path("fine", "summary.json")))
        self.refused("mesh", "tet", "pad.off", "-o", NOWHERE + ".vtu")
        self.assertFalse(os.path.exists(self.path("fine")), "a folder that nothing was written to is removed")

    def test_a_full_disk_is_seen_before_the_work(self):
        def no_bytes():
            resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
        for words in (["run", "s.json", "--no-report", "--set", "duration=600", "--out", "o"], ["mesh", "tet", "pad.off", "-o", "x.vtu"]):
            self.refused(*words, preexec_fn=no_bytes)
        self.assertEqual(sorted(os.listdir(self.folder)), ["pad.off", "s.json"])

    def test_something_else_in_a_files_place_is_seen_before_the_work(self):
        for name in ("trace.csv", "session.json", "report.html"):
            os.makedirs(self.path("o", name))
            self.refused("run", "s.json", "--set", "duration=600", "--out", "o", says=(name,))
            os.rmdir(self.path("o", name))
        os.mkfifo(self.path("o", "trace.csv"))
        self.refused("run", "s.json", "--set", "duration=600", "--out", "o", says=("pipe",))

    # --- A folder belongs to one run; its files are whole, of one run, and follow no link.

    def test_two_runs_into_one_folder(self):
        first = subprocess.Popen([PROGRAM, "run", "s.json", "--no-report", "--out", "o", "--set", "duration=null", "--set", "contact.mu=0.1"],
                                 cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(first.kill)
        while not os.path.isdir(self.path("o")):
            time.sleep(0.01)
        for words in (["run", "s.json", "--no-report"], ["run", "s.json", "--no-report", "--force"], ["check", "pad.off"]):
            self.refused(*words, "--out", "o", says=("another kilotouch",))
        time.sleep(1)
        first.send_signal(signal.SIGTERM)
        first.wait(timeout=60)
        with open(self.path("o", "scene.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["contact"]["mu_static"], 0.1)
        self.succeeds("run", "s.json", "--no-report", "--out", "o")

    def test_pictures_of_an_earlier_run_go(self):
        self.succeeds("run", "s.json", "--no-report", "--out", "o")
        for name in ("report.html", "force.png", "mesh.png", "force.svg"):
            with open(os.path.join(self.folder, "o", name), "w", encoding="ascii") as file:
                file.write("of a run before\n")
        self.succeeds("run", "s.json", "--no-report", "--out", "o", "--set", "contact.mu=0.1")
        self.assertEqual({f for f in os.listdir(os.path.join(self.folder, "o")) if f.startswith(("report", "force", "mesh"))}, set())

    def test_two_commands_with_one_json_file(self):
        first = subprocess.Popen([PROGRAM, "run", "s.json", "--no-report", "--out", "o", "--json", "a.json", "--set", "duration=null"],
                                 cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(first.kill)
        while not os.path.isdir(self.path("o")):  # made after the options were read
            time.sleep(0.01)
        os.symlink("a.json", self.path("link.json"))
        for name in ("a.json", self.path("a.json"), "link.json"):
            self.refused("run", "s.json", "--no-report", "--out", "p", "--json", name, says=("--json", "another kilotouch"))
        self.refused("mesh", "info", "pad.off", "--json", "a.json", says=("another kilotouch",))
        self.assertFalse(os.path.exists(self.path("p")))
        self.succeeds("mesh", "info", "pad.off", "--json", "b.json")
        first.send_signal(signal.SIGTERM)
        first.wait(timeout=60)
        self.succeeds("mesh", "info", "pad.off", "--json", "a.json")

    def test_links_in_the_folder_are_not_followed(self):
        names = ["scene.json", "trace.csv", "events.csv", "summary.json", "view.json", "recording.csv", "session.json", "reference.csv",
                 "force.png", "mesh.png", "report.html", "states.pvd"]
        os.mkdir(self.path("o"))
        for name in names:
            self.write("of_somebody_" + name, "theirs")
            os.symlink("../of_somebody_" + name, self.path("o", name))
        self.succeeds("run", "s.json", "--out", "o", "--states", "--reference", "--force")
        for name in names:
            with self.subTest(name):
                with open(self.path("of_somebody_" + name), encoding="utf-8") as file:
                    self.assertEqual(file.read(), "theirs")
                self.assertFalse(os.path.islink(self.path("o", name)))
        shutil.rmtree(self.path("o", "session"))
        os.mkdir(self.path("elsewhere"))
        os.symlink("../elsewhere", self.path("o", "session"))
        self.refused("run", "s.json", "--no-report", "--out", "o", says=("link",))
        self.assertEqual(os.listdir(self.path("elsewhere")), [])

    def test_links_in_the_folder_of_a_check_are_not_followed(self):
        os.mkdir(self.path("o"))
        names = ["rows.jsonl.settings.json", "report.json", "outlines.json"]
        for name in names:
            self.write("of_somebody_" + name, "theirs")
            os.symlink("../of_somebody_" + name, self.path("o", name))
        self.succeeds("check", "pad.off", "--until", "load", "--no-report", "--out", "o")
        self.write("rows", "theirs")
        os.remove(self.path("o", "rows.jsonl"))
        os.symlink("../rows", self.path("o", "rows.jsonl"))
        self.refused("check", "pad.off", "--until", "load", "--no-report", "--out", "o", says=("link",))
        for name in ["rows", *("of_somebody_" + name for name in names)]:
            with open(self.path(name), encoding="utf-8") as file:
                self.assertEqual(file.read(), "theirs")

    def test_what_does_not_fit_leaves_the_results_that_were_there(self):
        self.succeeds("run", "s.json", "--no-report", "--out", "o")
        names = sorted(os.listdir(self.path("o")))
        before = {name: digest(self.path("o", name)) for name in names if name != "session"}
        sizes = sorted(os.path.getsize(self.path("o", name)) for name in before)
        for most in (int(0.9 * sizes[-1]), sizes[len(sizes) // 2], 5000):  # the shell's `ulimit -f`: SIGXFSZ
            with self.subTest(most):
                out = self.run_program("run", "s.json", "--no-report", "--out", "o", "--set", "contact.mu=0.9",
                                       preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (most, most)))
                self.assertEqual(out.returncode, 2, out.stderr)
                self.assertIn("File too large", out.stderr)
                self.assertEqual(sorted(os.listdir(self.path("o"))), names)
                self.assertEqual({name: digest(self.path("o", name)) for name in before}, before)

    # --- Signals.

    def started(self, *words, **more):
        process = subprocess.Popen([PROGRAM, "run", "s.json", "--no-report", "--out", "o", *words], cwd=self.folder, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, **more)
        self.addCleanup(process.kill)
        return process

    def ticks_kept(self):
        with open(self.path("o", "trace.csv"), encoding="utf-8") as file:
            return len(file.readlines()) - 1

    def test_a_terminal_that_is_closed_ends_a_run_with_its_results(self):
        for words in (["--set", "duration=null"], ["--set", "duration=null", "--set", "link.type=thread"]):
            process = self.started(*words)
            while not os.path.isdir(self.path("o")):
                time.sleep(0.01)
            time.sleep(3)
            process.send_signal(signal.SIGHUP)
            _, error = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 128 + signal.SIGHUP, error)
            self.assertIn("SIGHUP", error)
            self.assertGreater(self.ticks_kept(), 0)
            self.assertIn("bit for bit", self.run_program("replay", "o").stdout)  # exit code 1 where it lost a contact
            shutil.rmtree(self.path("o"))

    def test_who_asks_for_no_hangup_gets_none(self):
        process = self.started("--set", "duration=0.5", preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))  # nohup
        time.sleep(0.5)
        process.send_signal(signal.SIGHUP)
        _, error = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, error)
        self.assertEqual(self.ticks_kept(), 500)

    # --- Sessions.

    def replays(self, *folders, **more):
        for folder in folders:
            out = self.succeeds("replay", folder, **more)
            self.assertIn("bit for bit", out.stdout)

    def test_a_session_replays_from_anywhere(self):
        self.succeeds("run", "s.json", "--no-report", "--out", "o")
        self.replays("o", "o/session.json")
        self.replays(self.path("o"), cwd="/")
        os.rename(self.path("o"), self.path("renamed"))
        os.remove(self.path("pad.off"))
        self.replays(self.path("renamed"), cwd="/")
        self.replays("renamed")
        shutil.move(self.folder, self.folder + "_moved")
        self.replays(self.folder + "_moved/renamed", cwd="/")
        self.succeeds("replay", self.folder + "_moved/renamed", "--out", self.folder + "_again", cwd="/")
        self.replays(self.folder + "_again", cwd="/")

    def test_a_pair_of_files_a_tools_mesh_and_a_recording_are_held(self):
        self.write("cube.1.node", NODES)
        self.write("cube.1.ele", ELEMENTS)
        self.write("tip.off", TIP)
        rows = ["t,x,y,z"] + [f"{0.001 * i:.3f},0.0199,0.0201,{0.0249 - 2e-5 * min(i, 60):.5f}" for i in range(100)]
        self.write("way.csv", "\n".join(rows) + "\n")
        self.write_scene("pair.json", duration=0.09)
        with open(self.path("pair.json"), encoding="utf-8") as file:
            scene = json.load(file)
        scene["object"] = {"mesh": "cube.1.node"}
        scene["tool"] = {"shape": "mesh", "mesh": "tip.off", "radius": 0.002, "path": {"recording": "way.csv"}}
        self.write("pair.json", json.dumps(scene))
        self.succeeds("run", "pair.json", "--no-report", "--out", "o")
        self.assertEqual(sorted(os.listdir(self.path("o", "session"))), ["body.ele", "body.node", "tool.off"])
        for name in ("cube.1.node", "cube.1.ele", "tip.off", "way.csv"):
            os.remove(self.path(name))
        self.replays(self.path("o"), cwd="/")
        # Another mesh in the same folder: what the first run held is no part of the second.
        self.succeeds("run", "s.json", "--no-report", "--out", "o", "--force")
        self.assertEqual(os.listdir(self.path("o", "session")), ["body.off"])
        self.replays("o")

    def test_a_mesh_that_is_not_the_runs_any_more_is_told(self):
        self.succeeds("run", "s.json", "--no-report", "--out", "o")
        held, own = self.path("o", "session", "body.off"), self.path("pad.off")
        with open(own, "a", encoding="utf-8") as file:
            file.write("# a word more\n")
        self.replays("o")  # by what the session holds
        os.remove(held)
        self.refused("replay", "o", says=("pad.off", "not the mesh of the run"))
        os.remove(own)
        self.refused("replay", "o", says=("pad.off", "gone"))
        shutil.copy(PAD, own)
        self.replays("o")
        self.replays(self.path("o"), cwd="/")
        self.write(os.path.join("o", "session", "body.off"), "OFF\n0 0 0\n")
        self.refused("replay", "o", says=("body.off", "not the mesh of the run"))

    def test_a_session_opens_no_file_but_those_that_it_holds(self):
        self.succeeds("run", "s.json", "--no-report", "--out", "o")
        with open(self.path("o", "session.json"), encoding="utf-8") as file:
            session = json.load(file)
        for name in ("../../pad.off", "/etc/passwd", "..", ""):
            session["files"][0]["file"] = name
            self.write(os.path.join("o", "session.json"), json.dumps(session))
            self.refused("replay", "o", says=("files[0]",))
        session["files"][0]["file"] = "body.off"
        self.write(os.path.join("o", "session.json"), json.dumps(session))
        os.remove(self.path("o", "session", "body.off"))
        os.symlink(self.path("pad.off"), self.path("o", "session", "body.off"))
        self.refused("replay", "o", says=("files[0]",))
        session["files"][0]["key"] = "object.model"
        self.write(os.path.join("o", "session.json"), json.dumps(session))
        self.refused("replay", "o", says=("files[0]", "object.model"))

    def test_an_older_session_replays_where_its_mesh_lies(self):
        self.succeeds("run", "s.json", "--no-report", "--out", "o")
        with open(self.path("o", "session.json"), encoding="utf-8") as file:
            session = json.load(file)
        del session["files"]
        session["scene"]["object"]["mesh"] = "pad.off"
        self.write(os.path.join("o", "session.json"), json.dumps(session))
        shutil.rmtree(self.path("o", "session"))
        self.replays("o")

    def test_the_scene_of_a_folder_runs_from_anywhere(self):
        self.succeeds("run", "s.json", "--no-report", "--out", "o")
        self.succeeds("run", self.path("o", "scene.json"), "--no-report", "--out", self.path("again"), cwd="/")
        hashes = set()
        for folder in ("o", "again"):
            with open(self.path(folder, "summary.json"), encoding="utf-8") as file:
                hashes.add(json.load(file)["hash"])
        self.assertEqual(len(hashes), 1)

    # --- A check goes on by what files hold, not by their names.

    def test_a_mended_mesh_is_checked_again_and_a_renamed_one_is_not(self):
        library = self.path("lib")
        os.mkdir(library)
        with open(PAD, encoding="utf-8") as file:
            whole = file.read()
        self.write("lib/whole.off", whole)
        self.write("lib/broken.off", whole[: len(whole) // 2])
        words = ["check", "lib", "--until", "doctor", "--no-report", "--out", "o"]
        self.assertEqual(self.run_program(*words).returncode, 1)
        self.write("lib/broken.off", whole.replace("OFF", "OFF\n# mended", 1))
        out = self.succeeds(*words, "--resume")
        self.assertIn("2 meshes: 2 pass", out.stdout)
        with open(self.path("o", "rows.jsonl"), encoding="utf-8") as file:
            rows = {row["key"]: row for row in map(json.loads, file)}
        os.rename(self.path("lib/whole.off"), self.path("lib/another.off"))
        self.succeeds(*words, "--resume")
        with open(self.path("o", "rows.jsonl"), encoding="utf-8") as file:
            after = {row["key"]: row for row in map(json.loads, file)}
        self.assertEqual(sorted(after), ["another.off", "broken.off"])
        self.assertEqual(after["another.off"]["seconds"], rows["whole.off"]["seconds"], "was checked again")
        self.assertEqual(after["broken.off"], rows["broken.off"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
