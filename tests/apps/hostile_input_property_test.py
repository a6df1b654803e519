#!/usr/bin/python3
"""Files, names and folders that are made to harm: one line and exit code 2, or the right result; never a crash, a hang,
a device that is replaced, half a file, or a page that runs what a name holds. KILOTOUCH names the program."""
import json
import os
import re
import shutil
import stat
import subprocess
import sys
import tempfile
import threading
import unittest

from patience import PATIENCE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")
PRESS = {"press_drag": {"depth": 0.002, "press_time": 0.03}}


def scene(**changes):
    return dict({"duration": 0.05, "object": {"mesh": "pad.off", "layers": {"count": 1, "thickness": 0.001}},
                 "tool": {"path": PRESS}, "local": {"reducer": "wall"}}, **changes)


class HostileInput(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = temporary.name
        shutil.copy(os.path.join(ROOT, "meshes", "pad.off"), self.path("pad.off"))

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def write(self, name, content):
        with open(self.path(name), "wb" if isinstance(content, bytes) else "w") as file:
            file.write(content if isinstance(content, (bytes, str)) else json.dumps(content))
        return name

    def kilotouch(self, *words, status=0, **options):
        result = subprocess.run([PROGRAM, *words], cwd=self.folder, capture_output=True, text=True, errors="surrogateescape", **{"timeout": PATIENCE, **options})
        self.assertEqual(result.returncode, status, result.stdout + result.stderr)
        return result

    def refused(self, *words, says=(), **options):
        error = self.kilotouch(*words, status=2, **options).stderr
        self.assertRegex(error, r"\Akilotouch[^\n]*: [^\n]+\n\Z")
        self.assertNotRegex(error, r"json\.exception|bad_alloc|std::|terminate")
        for word in says:
            self.assertIn(word, error)
        return error

    def read_pipe(self, name):
        """A pipe with somebody at its other end; what came is in the list."""
        os.mkfifo(self.path(name))
        got = []

        def read():
            with open(self.path(name), "rb") as file:
                got.append(file.read())
        thread = threading.Thread(target=read, daemon=True)
        thread.start()
        return thread, got

    # ---- outputs

    def test_a_pipe_is_written_to_and_stays_a_pipe(self):
        self.write("s.json", scene())
        thread, got = self.read_pipe("pipe")
        self.kilotouch("run", "s.json", "--no-report", "--out", "o", "--json", "pipe")
        thread.join(10)
        self.assertTrue(stat.S_ISFIFO(os.stat(self.path("pipe")).st_mode))
        with open(self.path("o", "summary.json"), encoding="utf-8") as file:
            self.assertEqual(json.loads(got[0]), json.load(file))
        thread, got = self.read_pipe("pipe.off")
        self.kilotouch("mesh", "repair", "pad.off", "-o", "pipe.off")
        thread.join(10)
        self.assertTrue(stat.S_ISFIFO(os.stat(self.path("pipe.off")).st_mode))
        self.assertTrue(got[0].startswith(b"OFF"))

    def test_a_pipe_that_nobody_reads_is_refused_after_a_while(self):
        os.mkfifo(self.path("pipe"))
        self.refused("list", "--json", "pipe", says=["pipe", "nobody reads"])

    def test_a_device_is_written_to_and_stays_a_device(self):
        try:
            os.mknod(self.path("zero"), stat.S_IFCHR | 0o600, os.makedev(1, 3))  # as /dev/null
            os.mknod(self.path("full"), stat.S_IFCHR | 0o600, os.makedev(1, 7))  # as /dev/full
            os.mknod(self.path("disk"), stat.S_IFBLK | 0o600, os.makedev(7, 250))
            open(self.path("zero"), "wb").close()
        except PermissionError:
            self.skipTest("may make no device")
        self.kilotouch("list", "--json", "zero")
        self.refused("list", "--json", "full", says=["full", "No space left"])
        self.refused("list", "--json", "disk", says=["disk", "not a file"])
        for name, kind in (("zero", stat.S_ISCHR), ("full", stat.S_ISCHR), ("disk", stat.S_ISBLK)):
            self.assertTrue(kind(os.stat(self.path(name)).st_mode), name)

    def test_a_link_stays_a_link_and_modes_stay(self):
        self.write("old.json", "{}")
        os.chmod(self.path("old.json"), 0o640)
        os.symlink("old.json", self.path("link.json"))
        os.symlink("new.json", self.path("dangling.json"))
        for name in ("link.json", "dangling.json"):
            self.kilotouch("list", "--json", name)
            self.assertTrue(os.path.islink(self.path(name)))
        for name in ("old.json", "new.json"):
            with open(self.path(name), encoding="utf-8") as file:
                self.assertIn("contact.law", json.load(file))
        self.assertEqual(os.stat(self.path("old.json")).st_mode & 0o777, 0o640)
        self.assertEqual([name for name in os.listdir(self.folder) if "kilotouch-" in name], [])

    def test_output_that_cannot_be_written_is_no_success(self):
        for command in (["list"], ["--version"], ["mesh", "info", "pad.off"]):
            words = " ".join([PROGRAM, *command])
            for redirection in (">/dev/full", ">&-"):
                result = subprocess.run(["bash", "-c", f"{words} {redirection}"], cwd=self.folder, capture_output=True, text=True)
                self.assertEqual(result.returncode, 1, words + redirection)
                self.assertIn("standard output cannot be written", result.stderr)
        # A reader that leaves costs no results; an output that is closed takes no file's place.
        self.write("s.json", scene())
        subprocess.run(["bash", "-c", f"{PROGRAM} run s.json --no-report --out o | true; {PROGRAM} run s.json --no-report --out p >&-"], cwd=self.folder, capture_output=True)
        for out in ("o", "p"):
            with open(self.path(out, "summary.json"), encoding="utf-8") as file:
                self.assertEqual(json.load(file)["ticks"]["total"], 50)

    def test_a_full_disk_leaves_no_half_page(self):
        if os.geteuid() != 0 or subprocess.run(["unshare", "-m", "true"], capture_output=True).returncode != 0:
            self.skipTest("may mount nothing")
        os.makedirs(self.path("lib"))
        for i in range(3):
            shutil.copy(self.path("pad.off"), self.path("lib", f"{i}.off"))
        os.mkdir(self.path("small"))
        script = ("mount -t tmpfs -o size=1m tmpfs small && head -c 990000 /dev/zero >small/fill; "
                  f"{PROGRAM} check lib --until doctor --out small/o; code=$?; ls -A small/o >names; test ! -e small/o/report.html && exit $code; "
                  "tail -c 10 small/o/report.html | grep -q '</html>' && exit $code; exit 99")
        result = subprocess.run(["unshare", "-m", "bash", "-c", script], cwd=self.folder, capture_output=True, text=True)
        self.assertNotEqual(result.returncode, 99, "half a page")
        self.assertTrue(result.returncode != 0 or "warning" in result.stderr, result.stderr)
        self.assertNotIn("Traceback", result.stderr)
        with open(self.path("names"), encoding="utf-8") as file:
            self.assertNotIn(".kilotouch-", file.read())

    def test_results_of_another_run_are_replaced_only_when_told(self):
        self.write("s.json", scene(title="first"))
        self.write("t.json", scene(title="second"))
        run = ["run", "--no-report", "--out", "o"]
        first = self.kilotouch(*run, "s.json").stdout
        self.assertNotIn("in place of", first)
        self.assertNotIn("in place of", self.kilotouch(*run, "s.json").stdout)
        self.assertIn("in place of a run with other settings", self.kilotouch(*run, "s.json", "--set", "contact.mu=0.2").stdout)
        self.refused(*run, "t.json", says=["--out o", "first", "--force"])
        with open(self.path("o", "summary.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["scene"], "first")
        self.kilotouch(*run, "t.json", "--force")
        self.kilotouch("run", "s.json", "--no-report")  # the default folder holds the last run, whatever it was
        self.kilotouch("run", "t.json", "--no-report")

    def test_the_line_to_run_it_again_is_one_for_a_shell(self):
        name = "it's $(touch harm) a.off"
        shutil.copy(self.path("pad.off"), self.path(name))
        words = ["run", name, "--set", "duration=0.05", "--set", "object.layers.thickness=0.001", "--set", "local.reducer=wall"]
        self.kilotouch(*words, "--no-report", "--out", "o")
        with open(self.path("o", "summary.json"), encoding="utf-8") as file:
            command = json.load(file)["command"]
        again = subprocess.run(["bash", "-c", f'set -- {command}; shift; printf "%s\\n" "$@"'], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(again.stdout.splitlines(), words)
        self.assertFalse(os.path.exists(self.path("harm")))

    # ---- names

    def test_names_that_are_no_utf8_keep_their_bytes(self):
        name = os.fsdecode(b"b\xffd.off")
        shutil.copy(self.path("pad.off"), self.path(name))
        self.kilotouch("drag", name, "--no-report", "--set", "duration=0.05", "--set", "object.layers.thickness=0.001", "--set", "local.reducer=wall", "--out", "d")
        self.assertIn("bit for bit", self.kilotouch("replay", "d").stdout)
        os.mkdir(self.path("lib"))
        for other in (b"b\xffd.off", b"b\xfed.off", b"b\\xffd.off"):
            shutil.copy(self.path("pad.off"), os.path.join(os.fsencode(self.path("lib")), other))
        words = ["check", "lib", "--until", "load", "--no-report", "--out", "o"]
        self.kilotouch(*words)
        with open(self.path("o", "rows.jsonl"), "rb") as file:
            rows = file.read()
        self.kilotouch(*words, "--resume")
        with open(self.path("o", "rows.jsonl"), "rb") as file:
            self.assertEqual(file.read(), rows)
        self.assertEqual(sorted(json.loads(line)["key"] for line in rows.splitlines()), ["b\\x5cxffd.off", "b\\xfed.off", "b\\xffd.off"])
        self.assertIn("3 meshes", self.kilotouch("check", "merge", "o", "--no-report", "--out", "m").stdout)

    def test_no_name_steers_the_terminal(self):
        error = self.refused("mesh", "info", "a\x1b[2J\n\u202eb\u2028\x9b.off", says=["\\x1b[2J\\n", "\\u202e", "\\u2028", "\\u009b"])
        self.assertNotIn("\x1b", error)
        shutil.copy(self.path("pad.off"), self.path("a\x1b[2J.off"))
        self.assertIn("a\\x1b[2J.off", self.kilotouch("mesh", "info", "a\x1b[2J.off").stdout)
        self.refused("ru\x1bn\u2029", says=["ru\\x1bn\\u2029"])

    @unittest.skipUnless(BROWSER, "needs chromium")
    def test_a_mesh_name_is_shown_and_not_run(self):
        """In the cell, in search and sorting, in opened rows, in the data's own script, and from rows of others."""
        os.mkdir(self.path("lib"))
        evil = ["z&<img src=\"\u2029\" onerror=document.body.id='P2'>.off", "a'><svg onload=document.body.id=1>.off", "<!--<script>.off"]
        for name in evil:
            shutil.copy(self.path("pad.off"), self.path("lib", name))
        self.kilotouch("check", "lib", "--until", "load", "--no-report", "--out", "o")
        with open(self.path("o", "rows.jsonl"), encoding="utf-8") as file:
            row = json.loads(file.readline())
        row["key"] = "foreign</script><script>document.body.id=3</script>"
        row["result"]["stages"][0].update(verdict="fail", why="w&<img src=x onerror=document.body.id=4>", figures={"<b onclick=1>": "&<img src=x onerror=document.body.id=5>"})
        with open(self.path("o", "rows.jsonl"), "a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        self.kilotouch("check", "merge", "o", "--out", "m", status=1)
        with open(self.path("m", "report.html"), encoding="utf-8") as file:
            page = file.read()
        # Searches, sorts and opens every row.
        page = page.replace("</body>", "<script>const s = byId('search'), look = w => { s.value = w; s.dispatchEvent(new Event('input')); }; look('z&<im'); "
                                       "document.body.dataset.found = document.querySelectorAll('#table tr.row').length; look(''); table.order(1, true); "
                                       "document.querySelectorAll('#table tr.row').forEach(r => r.click());</script></body>")
        with open(self.path("m", "opened.html"), "w", encoding="utf-8") as file:
            file.write(page)
        dom = subprocess.run([BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={self.path('c')}", "--virtual-time-budget=3000", "--dump-dom",
                              "file://" + self.path("m", "opened.html")], capture_output=True, text=True, timeout=PATIENCE).stdout
        self.assertNotRegex(dom, r"<body[^>]* id=")
        self.assertNotRegex(dom, r"<td[^>]*>[^<]*<(svg|b onclick)")
        for shown in ("&lt;!--&lt;script&gt;.off</td>", "foreign&lt;/script&gt;&lt;script&gt;", "z&amp;&lt;img src="):
            self.assertRegex(dom, '<td class="path[^"]*">' + shown)
        self.assertEqual(dom.count('<div class="stages">'), 4)
        self.assertIn('data-found="1"', dom)

    # ---- inputs

    def test_numbers_out_of_reach_are_refused(self):
        """A tick that does not fit, coordinates whose squares are infinite, records that no memory holds."""
        self.write("s.json", scene())
        self.refused("run", "s.json", "--set", "duration=1e-9", says=["duration", "1e-09", "one tick", "0.001 s"])
        self.refused("run", "s.json", "--set", "duration=3600", "--set", "local.rate_hz=1e6", says=["duration", "3600", "1e+09 ticks"])
        far = [[0, 1e200, 0, 0], [0.05, -1e200, 0, 0]]
        self.refused("run", self.write("far.json", scene(tool={"path": {"waypoints": far}})), says=["tool.path.waypoints[0][1]", "1e+200", "1e+06"])
        self.refused("run", "s.json", "--set", "tool.path.press_drag.at=[1e200,0]", says=["at[0]", "1e+200"])
        self.refused("run", "s.json", "--set", "object.gravity=[0,0,1e300]", says=["object.gravity[2]", "1e+300"])
        self.write("far.csv", "t,x,y,z\n0,0,0,1\n0.001,0,0,1e200\n")
        self.refused("run", "s.json", "--set", "tool.path.recording=far.csv", says=["far.csv:3", "1e200", "1e+06"])
        with open(self.path("pad.off"), encoding="utf-8") as file:
            lines = file.read().splitlines()
        first = next(i for i, line in enumerate(lines) if len(line.split()) == 3 and "." in line)
        lines[first] = "1e200 0 0"
        self.write("far.off", "\n".join(lines) + "\n")
        self.refused("run", "s.json", "--set", "object.mesh=far.off", says=["far.off:5", "1e200", "1e+100"])

    def test_options_that_are_no_numbers_or_do_nothing_are_refused(self):
        """CLI11 takes nan for a number in every range; a rate of 1e308 Hz would be worked at for ever."""
        self.write("s.json", scene())
        self.refused("run", "s.json", "--reference", "--reference-rate", "1e308", says=["--reference-rate", "1e+308", "1e+07"])
        for option, value in (("--timeout", "nan"), ("--memory", "nan"), ("--memory", "1e308"), ("--young", "nan"), ("--backend-timeout", "-nan")):
            self.refused("check", "pad.off", "--until", "load", "--no-report", "--out", "o", f"{option}={value}", says=[option, value])
        self.refused("chart", "s.json", "--timeout=nan", says=["--timeout", "nan"])
        self.refused("device", "test", "--machine", "--rate", "nan", says=["--machine", "--rate"])
        self.refused("view", "s.json", "--port", "0", "--record", "pad.off", says=["--record", "pad.off", "not a folder"])

    def test_a_tool_as_good_as_a_plate_is_refused(self):
        """It touches more of the surface at once than is held: it had hundreds of newtons where three are right."""
        shutil.copy(os.path.join(ROOT, "meshes", "slab_coarse.off"), self.path("slab.off"))
        with open(self.path("slab.off"), encoding="utf-8") as file:
            points = [tuple(map(float, w)) for w in (line.split() for line in file) if len(w) == 3 and "." in "".join(w)]
        x, y, top = (max(p[0] for p in points) / 2, max(p[1] for p in points) / 2, max(p[2] for p in points))
        way = [[0, x, y, top + 1.001], [0.05, x, y, top + 0.998]]
        self.write("s.json", scene(object={"mesh": "slab.off"},
                                   tool={"shape": "sphere", "radius": 1, "path": {"waypoints": way}}))
        self.refused("run", "s.json", says=["tool: it touches about", "40 places", "tool.radius"])

    def test_figures_that_no_memory_holds_are_refused_before_the_run(self):
        import resource
        limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))
        self.write("s.json", scene())
        error = self.kilotouch("run", "s.json", "--set", "duration=3600", "--set", "local.rate_hz=10000", status=2, preexec_fn=limit).stderr
        self.assertRegex(error, r"3\.6e\+07 ticks, whose figures in memory take 5\.4 GB; .*GB are free, enough for \d+")

    def test_nesting_has_a_limit(self):
        deep = "[" * 200000 + "]" * 200000
        self.write("deep.json", '{"object": {"mesh": %s}}' % deep)
        self.refused("run", "deep.json", says=["deep.json:1", "100 levels"])
        self.write("s.json", scene())
        self.refused("run", "s.json", "--set", "contact.regions=" + "[" * 60000, says=["--set", "100 levels"])
        self.write("strings.json", scene(title="[" * 300))  # in a text they are none
        self.kilotouch("run", "strings.json", "--no-report")
        self.write("baseline.json", deep)
        self.refused("check", "pad.off", "--until", "load", "--no-report", "--out", "o", "--baseline", "baseline.json", says=["baseline.json:1", "100 levels"])

    def test_pipes_and_folders_are_no_input(self):
        os.mkfifo(self.path("pipe"))
        os.mkdir(self.path("folder"))
        self.write("s.json", scene())
        for name in ("pipe", "folder"):
            self.refused("run", name, says=[name])
            self.refused("run", "s.json", "--set", f"tool.path.recording={name}", says=[name])
            self.refused("run", "s.json", "--reference-file", name, says=[name])
            self.refused("run", "s.json", "--truth", name, says=[name])
            self.refused("check", "pad.off", "--until", "load", "--out", "o", "--baseline", name, says=[name])
        self.refused("replay", "pipe", says=["pipe"])
        for extension in ("off", "obj", "ply", "stl", "msh", "vtu", "node"):
            os.mkfifo(self.path("pipe." + extension))
            self.refused("mesh", "info", "pipe." + extension, says=["not a regular file"])
        os.makedirs(self.path("rows", "x"))
        os.mkfifo(self.path("rows", "rows.jsonl"))
        self.refused("check", "pad.off", "--until", "load", "--no-report", "--out", "rows", says=["rows.jsonl", "not a regular file"])

    def test_links_to_folders_above_are_not_entered(self):
        os.makedirs(self.path("up", "lib", "deep"))
        shutil.copy(self.path("pad.off"), self.path("up", "lib", "deep", "pad.off"))
        shutil.copy(self.path("pad.off"), self.path("up", "above.off"))
        os.mkdir(self.path("elsewhere"))
        shutil.copy(self.path("pad.off"), self.path("elsewhere", "other.off"))
        for name, to in (("a", ".."), ("b", "."), ("c", "../.."), ("deep/d", "../deep"), ("self", "self"), ("e", "/"), ("f", self.path("elsewhere")), ("g", self.path("elsewhere"))):
            os.symlink(to, self.path("up", "lib", name))
        self.kilotouch("check", self.path("up", "lib"), "--until", "load", "--no-report", "--out", "o")
        with open(self.path("o", "rows.jsonl"), encoding="utf-8") as file:
            self.assertEqual(sorted(json.loads(line)["key"] for line in file), ["deep/pad.off", "f/other.off"])

    def test_rows_and_reports_of_others_are_looked_at(self):
        """Keys that lack, kinds that are wrong: in a baseline, in rows to resume or to merge, in their settings."""
        words = ["check", "pad.off", "--until", "load", "--no-report", "--out", "o"]
        self.kilotouch(*words)
        with open(self.path("o", "rows.jsonl"), encoding="utf-8") as file:
            row = json.loads(file.read())
        for baseline in ('{"rows": [{}]}', '{"rows": 1}', "[]", "{}", '{"rows": [{"path": 1, "verdict": "fail"}]}', "{", "nul", '{"rows": [1e999]}'):
            self.write("baseline.json", baseline)
            self.refused(*words, "--baseline", "baseline.json", says=["baseline.json"])

        def changed(key, value, of=None):
            copy = json.loads(json.dumps(row))
            at = copy
            for step in of or []:
                at = at[step]
            if value is None:
                del at[key]
            else:
                at[key] = value
            return copy
        stage = ["result", "stages", 0]
        bad = [[], 1, {}, changed("outcome", None), changed("trouble", 7), changed("seconds", "x"), changed("result", 3), changed("result", None),
               changed("stages", {"a": 1}, ["result"]), changed("stages", [1], ["result"]), changed("verdict", "maybe", stage), changed("name", "<b>", stage),
               changed("why", None, stage), changed("where", ["x", 1, 2], stage), changed("figures", 1, stage), changed("triangles", "many", ["result"]),
               changed("times", {"cpu_s": "x"}, ["result"]), changed("running", 1, ["result"]), changed("outline", {"x": ["a"]}, ["result"])]
        for other in bad:
            with self.subTest(json.dumps(other)[:100]):
                self.write("o/rows.jsonl", json.dumps(other) + "\n")
                self.refused(*words, "--resume", says=["rows.jsonl, line 1"])
                self.refused("check", "merge", "o", "--no-report", "--out", "m", says=["rows.jsonl, line 1"])
        self.write("o/rows.jsonl", json.dumps(row) + "\n")
        for settings in ("{}", "[]", '{"timeout": "x", "memory_gb": 4}'):
            self.write("o/rows.jsonl.settings.json", settings)
            self.refused("check", "merge", "o", "--no-report", "--out", "m", says=["settings.json"])
            self.refused(*words, "--resume", says=["settings.json"])

    def test_sessions_of_others_are_looked_at(self):
        self.write("s.json", scene())
        self.kilotouch("run", "s.json", "--no-report", "--out", "o")
        with open(self.path("o", "session.json"), encoding="utf-8") as file:
            session = json.load(file)
        with open(self.path("secret.csv"), "w", encoding="utf-8") as file:
            file.write("t,x,y,z\nsecret\n")
        os.symlink("../secret.csv", self.path("o", "link.csv"))
        wrong = [("recording", "../secret.csv"), ("recording", self.path("secret.csv")), ("recording", "link.csv"), ("recording", ".."), ("recording", 1), ("recording", ""),
                 ("refreshes", []), ("refreshes", {}), ("refreshes", [[0, 0]]), ("refreshes", [[0, 0, "x"]]), ("refreshes", [[5, 5, 5]]), ("refreshes", [[0, -1, 0]]),
                 ("refreshes", [[0, 0, 0], [10 ** 12, 0, 0]]), ("refreshes", [[0, 0, 0], [9, 3, 9]]), ("max_speed", "fast"), ("max_speed", -1), ("max_speed", 1e300),
                 ("hash", 5), ("scene", 5), ("scene", {}), ("scene", dict(session["scene"], second_tool={"path": PRESS}))]
        for key, value in wrong:
            with self.subTest(f"{key} {str(value)[:60]}"):
                self.write("o/session.json", dict(session, **{key: value}))
                self.assertNotIn("secret\n", self.refused("replay", "o"))
        for key in ("scene", "recording", "refreshes", "max_speed", "hash"):
            self.write("o/session.json", {k: v for k, v in session.items() if k != key})
            self.refused("replay", "o", says=["session.json", key])
        self.write("o/session.json", session)
        self.kilotouch("replay", "o")

    def test_a_wrong_reference_is_refused_before_the_run(self):
        # 200 s take most of a minute: a run would not end within the limit.
        long = ["run", self.write("s.json", scene()), "--set", "duration=200", "--no-report", "--out", "o"]
        rows = "t,force_x,force_y,force_z\n" + "".join(f"{(i + 1) / 1000},0,0,0\n" for i in range(3))
        for content in ("", "words\n", "# kilotouch reference x\n", "# kilotouch reference 00000000000000aa 10000 0.001 1\nt\n",
                        "# kilotouch reference 00000000000000aa 10000 0.001 1\n" + rows, "# kilotouch reference 00000000000000aa 0 0 1\n" + rows,
                        "# kilotouch reference 00000000000000aa 10000 0.001 1\n" + rows + "0.004,nan,0,0\n"):
            self.write("r.csv", content)
            self.refused(*long, "--reference-file", "r.csv", says=["r.csv"], timeout=20)
            self.assertFalse(os.path.exists(self.path("o")))  # nothing was written: no folder is left


if __name__ == "__main__":
    unittest.main()
