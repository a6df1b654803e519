#!/usr/bin/python3
"""Every C++ file has the style of .clang-format. Version 14 decides, as in Debian 12. Other versions break lines elsewhere."""
import os
import re
import shutil
import subprocess
import unittest
from concurrent.futures import ThreadPoolExecutor

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
VERSION = "14"
TOOLS = [t for t in (f"clang-format-{VERSION}", "clang-format") if shutil.which(t)]


def version_of(tool):
    told = subprocess.run([tool, "--version"], capture_output=True, text=True).stdout
    return (re.search(r"version (\d+)", told) or ["", ""])[1]


def sources():
    """The files of the repository, or of the folder where it is no clone."""
    listed = subprocess.run(["git", "-C", ROOT, "ls-files", "-z", "*.cpp", "*.hpp"], capture_output=True, text=True)
    if listed.returncode == 0 and listed.stdout:
        return [f for f in listed.stdout.split("\0") if f and os.path.exists(os.path.join(ROOT, f))]
    found = []
    for at, folders, names in os.walk(ROOT):
        folders[:] = [f for f in folders if not f.startswith(".") and not (at == ROOT and f in ("build", "out"))]
        found += [os.path.relpath(os.path.join(at, n), ROOT) for n in names if n.endswith((".cpp", ".hpp"))]
    return found


class Format(unittest.TestCase):
    def test_every_file_has_the_style(self):
        tool = next((t for t in TOOLS if version_of(t) == VERSION), None)
        if tool is None:
            self.skipTest(f"needs clang-format {VERSION} (scripts/setup --dev)")
        files = sorted(sources())
        self.assertGreater(len(files), 1000)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            done = pool.map(lambda part: subprocess.run([tool, "--dry-run", "-Werror", *part], cwd=ROOT, capture_output=True, text=True),
                            [files[k:k + 100] for k in range(0, len(files), 100)])
        done = list(done)
        for d in done:
            self.assertTrue(d.returncode == 0 or "error" in d.stderr, f"{tool}: {d.stderr[:500]}")
        wrong = sorted({m[1] for d in done for m in re.finditer(r"^(\S+?):\d+:\d+: error", d.stderr, re.M)})
        self.assertEqual(wrong, [], "clang-format -i these")


if __name__ == "__main__":
    unittest.main()
