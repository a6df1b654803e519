#!/usr/bin/python3
"""The program as a file: what the linker and the loader must do for it. KILOTOUCH names the program."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))


def readelf(*options):
    return subprocess.run(["readelf", "-W", *options, PROGRAM], capture_output=True, text=True, check=True).stdout


@unittest.skipUnless(shutil.which("readelf"), "needs readelf (package binutils)")
class Hardening(unittest.TestCase):
    def test_libraries_are_found_by_full_paths_only(self):
        for entry in re.findall(r"\((?:RUNPATH|RPATH)\).*\[(.*)\]", readelf("-d")):
            for folder in entry.split(":"):
                self.assertTrue(folder.startswith("/") or folder.startswith("$ORIGIN"),
                                f"'{entry}': the entry '{folder}' is the folder in which the program is started")

    def test_no_library_of_the_current_folder_is_loaded(self):
        names = re.findall(r"\(NEEDED\).*\[(.*)\]", readelf("-d"))
        with tempfile.TemporaryDirectory() as folder:
            for name in names:  # not even libraries: the loader would stop at the first
                with open(os.path.join(folder, name), "w", encoding="ascii") as file:
                    file.write("no library\n")
            done = subprocess.run([PROGRAM, "--version"], cwd=folder, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_its_tables_are_read_only_and_its_place_in_memory_is_random(self):
        self.assertIn("GNU_RELRO", readelf("-l"))
        self.assertTrue(re.search(r"BIND_NOW|\(FLAGS_1\).*NOW", readelf("-d")), "tables of functions stay writable")
        self.assertRegex(readelf("-h"), r"Type:\s+DYN")
        stack = next(line for line in readelf("-l").splitlines() if "GNU_STACK" in line)
        self.assertNotIn("E", stack.split()[-2])

    def test_buffers_are_checked(self):
        symbols = readelf("--dyn-syms")
        if "__asan_init" in symbols or "__tsan_init" in symbols:
            self.skipTest("a sanitizer checks them")
        self.assertTrue("__stack_chk_fail" in symbols, "no canaries: -fstack-protector")
        self.assertTrue(re.search(r"__\w+_chk@", symbols), "no checked calls: _FORTIFY_SOURCE")


if __name__ == "__main__":
    unittest.main(verbosity=2, argv=sys.argv)
