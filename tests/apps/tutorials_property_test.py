#!/usr/bin/python3
"""Every tutorial as it is written: its commands are run in a folder of their own, and what they print is compared with the page.

A block of `sh` is run; the block of `text` after it is what it prints, where … stands for anything and figures may differ by 5 %.
A comment before a block says otherwise:
    <!-- file: NAME -->              the block is written to this file
    <!-- example: PATH -->           the block is that file of the repository, or a part of it
    <!-- exit code: N -->            how the command ends; any: as the load of the machine has it
    <!-- in the background -->       it goes on until the end of the page; the page of a server is opened
    <!-- long -->                    it is left out unless KT_LONG is set
    <!-- not run: REASON -->         it is not
KILOTOUCH names the program. A tutorial that needs what the build or the machine lacks is skipped, and says so.
"""
import contextlib
import glob
import importlib.util
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

from patience import PATIENCE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
PACKAGE = os.path.join(os.path.dirname(PROGRAM), "python")
NUMBER = re.compile(r"-?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")


def steps(page):
    """[(line, comment, language, code)] of the fenced blocks."""
    out, fenced, comment, code = [], None, "", []
    with open(page, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            if line.startswith("```"):
                if fenced is None:
                    fenced, begin, code = line[3:].strip(), number, []
                else:
                    out.append((begin, comment, fenced, "".join(code)))
                    fenced, comment = None, ""
            elif fenced is not None:
                code.append(line)
            elif m := re.match(r"<!-- (.*) -->$", line.strip()):
                comment = m[1]
    return out


def agree(told, printed):
    """One line of the page and one of the output: equal but for figures within 5 % and what … stands for."""
    places = [m.span() for m in NUMBER.finditer(told)]
    pattern, at = "", 0
    for begin, end in places:
        pattern += re.escape(told[at:begin]) + "(" + NUMBER.pattern + ")"
        at = end
    pattern = re.sub(r"(\\ )+", r"\\s+", (pattern + re.escape(told[at:].rstrip("\n"))).replace("…", ".*"))
    found = re.fullmatch(r"\s*" + pattern.strip() + r"\s*", printed)
    if not found:
        return False
    value = lambda text: float(text.replace(",", ""))
    return all(abs(value(a) - value(told[b:e])) <= 0.05 * abs(value(told[b:e])) + 1e-9 for a, (b, e) in zip(found.groups(), places))


class Tutorial:
    """The folder in which a page is followed: the files of the repository are there, as in a clone."""

    def __init__(self, test, page):
        self.test, self.page, self.background = test, page, []
        self.folder = tempfile.mkdtemp(prefix="tutorial_")
        for name in ("scenes", "meshes", "examples", "scripts"):
            os.symlink(os.path.join(ROOT, name), os.path.join(self.folder, name))
        tools = os.path.join(self.folder, ".bin")
        os.mkdir(tools)
        os.symlink(PROGRAM, os.path.join(tools, "kilotouch"))
        with open(os.path.join(tools, "xdg-open"), "w", encoding="ascii") as file:  # the browser
            file.write("#!/bin/sh\nexit 0\n")
        os.chmod(os.path.join(tools, "xdg-open"), 0o755)
        self.environment = dict(os.environ, PATH=tools + ":/usr/bin:/bin", PYTHONPATH=PACKAGE, PYTHONDONTWRITEBYTECODE="1", MPLBACKEND="Agg")

    def where(self, line):
        return f"{os.path.relpath(self.page, ROOT)}:{line}"

    def start(self, line, code):
        log = os.path.join(self.folder, f".out{len(self.background)}")
        with open(log, "w", encoding="utf-8") as out:
            process = subprocess.Popen(["bash", "-c", "exec " + code.strip()], cwd=self.folder, env=self.environment, stdout=out,
                                       stderr=subprocess.STDOUT)
        self.background.append(process)
        until, text = time.monotonic() + PATIENCE, ""
        while time.monotonic() < until and process.poll() is None:
            with open(log, encoding="utf-8") as file:
                text = file.read()
            if address := re.search(r"http://\S+", text):
                with urllib.request.urlopen(address[0], timeout=PATIENCE) as page:
                    self.test.assertIn(b"kilotouch", page.read(), self.where(line))
                return text
            if re.search(r"^serving .*\n", text, re.M):
                return text
            time.sleep(0.05)
        self.test.fail(f"{self.where(line)}: {text}")

    def run(self, line, comment, code):
        status = int(m[1]) if (m := re.match(r"exit code: (\d+)", comment)) else 0
        done = subprocess.run(["bash", "-e", "-o", "pipefail", "-c", code], cwd=self.folder, env=self.environment, text=True, timeout=PATIENCE,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if comment != "exit code: any":
            self.test.assertEqual(done.returncode, status, f"{self.where(line)}: {done.stdout}")
        return done.stdout

    def compare(self, line, told, printed):
        """The lines of the page in their order; the output may have others between them only where the page has …"""
        rest = [p for p in printed.split("\n") if p.strip()]
        skip = False
        for offset, wanted in enumerate(t for t in told.split("\n")):
            if not wanted.strip():
                continue
            if wanted.strip() == "…":
                skip = True
                continue
            while skip and rest and not agree(wanted, rest[0]):
                rest.pop(0)
            self.test.assertTrue(rest and agree(wanted, rest[0]),
                                 f"{self.where(line + 1 + offset)}: the page has\n  {wanted}\nthe program printed\n{printed}")
            rest.pop(0)
            skip = False
        self.test.assertTrue(skip or not rest, f"{self.where(line)}: the program printed more: {rest[:3]}")

    def follow(self):
        printed, ran = None, 0
        for line, comment, language, code in steps(self.page):
            if comment.startswith("not run") or (comment == "long" and not os.environ.get("KT_LONG")):
                continue
            if m := re.match(r"file: (\S+)", comment):
                with open(os.path.join(self.folder, m[1]), "w", encoding="utf-8") as file:
                    file.write(code)
            elif m := re.match(r"example: (\S+)", comment):
                with open(os.path.join(ROOT, m[1]), encoding="utf-8") as file:
                    self.test.assertIn(code, file.read(), self.where(line))
            elif language == "sh":
                printed = self.start(line, code) if comment == "in the background" else self.run(line, comment, code)
                ran += 1
            elif language == "text":
                self.test.assertIsNotNone(printed, f"{self.where(line)}: nothing was run before")
                self.compare(line, code, printed)
            elif language:
                self.test.fail(f"{self.where(line)}: a block of {language} that nobody tries; say file:, example: or not run:")
        self.test.assertGreater(ran, 0, self.page)

    def end(self):
        for process in self.background:
            process.send_signal(signal.SIGINT)
        for process in self.background:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(30)
            process.kill()
            process.wait()
        shutil.rmtree(self.folder)


def has_cgal():
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "list.json")
        subprocess.run([PROGRAM, "list", "--json", file], stdout=subprocess.DEVNULL, check=True)
        with open(file, encoding="utf-8") as listed:
            return any(b["name"] == "cgal" and b["available"] for family in json.load(listed).values() for b in family)


class Tutorials(unittest.TestCase):
    def lacks(self, page):
        with open(page, encoding="utf-8") as file:
            text = file.read()
        needs = (m[1] if (m := re.search(r"<!-- needs: (.*) -->", text)) else "").split()
        for what in needs:
            there = {"python": os.path.isdir(os.path.join(PACKAGE, "kilotouch")), "parallel": shutil.which("parallel"),
                     "matplotlib": importlib.util.find_spec("matplotlib"), "cgal": what == "cgal" and has_cgal()}.get(what)
            if there is None:  # a part of the build
                there = what in subprocess.run([PROGRAM, "--help"], capture_output=True, text=True).stdout
            if not there:
                return what
        return None


def of(page):
    def test(self):
        if missing := self.lacks(page):
            self.skipTest(f"needs {missing}")
        tutorial = Tutorial(self, page)
        try:
            tutorial.follow()
        finally:
            tutorial.end()
    return test


for page in sorted(glob.glob(os.path.join(ROOT, "docs", "tutorials", "*.md"))):
    setattr(Tutorials, "test_" + os.path.splitext(os.path.basename(page))[0], of(page))


class Comparison(unittest.TestCase):
    """What the page has is really compared."""

    def test_lines(self):
        self.assertTrue(agree("force 0.50 N (…)", "force 0.51 N (max 3)"))
        self.assertFalse(agree("force 0.50 N", "force 0.54 N"))
        self.assertFalse(agree("force 0.50 N", "force 0.50 mN"))
        self.assertTrue(agree("a  b", "a     b"))
        self.assertFalse(agree("1,000 ticks", "1,100 ticks"))


if __name__ == "__main__":
    unittest.main(verbosity=2, argv=sys.argv)
