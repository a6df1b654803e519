"""`python -m kilotouch.demo`: the live page on the organ that the command brings along, and what is said without a command."""
import os
import re
import subprocess
import sys
import tempfile
import unittest
import urllib.request

COMMAND = os.path.dirname(os.environ["KILOTOUCH"])


def demo(*options, path, **more):
    return subprocess.Popen([sys.executable, "-m", "kilotouch.demo", *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                            env={**os.environ, "PATH": path}, **more)


class Demo(unittest.TestCase):
    def test_the_page_opens_without_a_program_that_fills_surfaces(self):
        with tempfile.TemporaryDirectory() as folder, demo("--no-open", "--port", "0", path=COMMAND, cwd=folder) as server:
            try:
                line = server.stdout.readline()
                with urllib.request.urlopen(re.search(r"http://\S+", line)[0]) as answer:
                    self.assertIn("<title>kilotouch", answer.read().decode())
            finally:
                server.terminate()

    def test_without_the_command_one_line_says_which_package_is_missing(self):
        with tempfile.TemporaryDirectory() as folder, demo(path=folder) as tried:
            said = tried.communicate()[0]
        self.assertEqual(tried.returncode, 1)
        self.assertEqual(said, "kilotouch: the command kilotouch is neither in this package nor on the path: install the package kilotouch\n")


if __name__ == "__main__":
    unittest.main(verbosity=2)
