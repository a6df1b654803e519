#!/usr/bin/python3
"""Packages are made by scripts/package, and each is installed and used in a clean root of this system.

Needs root and what debootstrap fetches; without them the tests in the clean root are skipped and say so.
"""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
OUT = os.path.join(ROOT, "build", "packages")
GPL_PARTS = re.compile(r"lib(cholmod|gmp|mpfr|tet)\b")
PACKAGES = ("kilotouch", "libkilotouch0", "libkilotouch-dev", "python3-kilotouch", "kilotouch-doc")


def run(*words, **more):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    if done.returncode:
        raise AssertionError(f"{' '.join(words)}\n{done.stdout}")
    return done.stdout


def codename():
    with open("/etc/os-release", encoding="utf-8") as file:
        return re.search(r"^VERSION_CODENAME=(\w+)", file.read(), re.M)[1]


class Root:
    """A system with nothing but its minimal packages, in a folder."""

    def __init__(self, *packages):
        self.folder = tempfile.mkdtemp()
        run("debootstrap", "--variant=minbase", f"--include={','.join(['ca-certificates', *packages])}", codename(), self.folder)
        if os.path.exists("/etc/resolv.conf"):
            shutil.copy("/etc/resolv.conf", os.path.join(self.folder, "etc", "resolv.conf"))

    def words(self, command):
        """In a name space of mounts of its own: nothing stays mounted."""
        mounts = 'mount -t proc proc "$0/proc" && mount --rbind /dev "$0/dev" && exec chroot "$0" bash -ec "$1"'
        return ["unshare", "--mount", "--propagation", "private", "sh", "-c", mounts, self.folder, command]

    def run(self, command):
        return run(*self.words(f"export HOME=/root LC_ALL=C.UTF-8; cd /root; {command}"))

    def take(self, *files):
        for file in files:
            shutil.copy(file, os.path.join(self.folder, "root"))

    def page(self, command):
        """The page that the command serves."""
        server = subprocess.Popen(self.words(f"export HOME=/root; cd /root; exec {command} --port 0"), stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True)
        try:
            said = ""
            for line in server.stdout:
                said += line
                found = re.search(r"http://[\w.:]+/\S*", line)
                if found:
                    with urllib.request.urlopen(found[0], timeout=60) as answer:
                        return answer.read().decode()
            raise AssertionError(said)
        finally:
            server.terminate()
            server.communicate(timeout=60)

    def remove(self):
        shutil.rmtree(self.folder, ignore_errors=True)


def setUpModule():
    run(os.path.join(ROOT, "scripts", "package"), "deb", "wheel")


class Files(unittest.TestCase):
    def test_there_is_a_package_of_each_part(self):
        for name in PACKAGES:
            self.assertEqual(len(glob.glob(os.path.join(OUT, f"{name}_*.deb"))), 1, name)
        self.assertEqual(len(glob.glob(os.path.join(OUT, "kilotouch-*.whl"))), 1)

    def test_nothing_under_the_gpl_is_linked(self):
        with tempfile.TemporaryDirectory() as folder:
            for file in glob.glob(os.path.join(OUT, "*.deb")):
                run("dpkg-deb", "-x", file, folder)
            run(sys.executable, "-m", "zipfile", "-e", *glob.glob(os.path.join(OUT, "*.whl")), os.path.join(folder, "wheel"))
            seen = 0
            for place, _, names in os.walk(folder):
                self.assertFalse([name for name in names if GPL_PARTS.match(name)])
                for name in names:
                    file = os.path.join(place, name)
                    with open(file, "rb") as content:
                        if os.path.islink(file) or content.read(4) != b"\x7fELF":
                            continue
                    needed = run("readelf", "-d", file)
                    self.assertIsNone(re.search(r"NEEDED.*\[" + GPL_PARTS.pattern, needed), needed)
                    seen += 1
            self.assertGreater(seen, 6)

    def test_no_file_names_the_folder_of_the_build(self):
        with tempfile.TemporaryDirectory() as folder:
            for file in glob.glob(os.path.join(OUT, "*.deb")):
                run("dpkg-deb", "-x", file, folder)
            found = subprocess.run(["grep", "-rlF", ROOT + "/", folder], capture_output=True, text=True)
        self.assertEqual(found.stdout, "")


@unittest.skipUnless(os.geteuid() == 0 and shutil.which("debootstrap"), "a clean root needs root and debootstrap")
class DebianPackages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = Root()
        cls.addClassCleanup(cls.root.remove)
        cls.root.take(*glob.glob(os.path.join(OUT, "*.deb")))
        cls.root.run("apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -q -y ./*.deb g++ cmake make")

    def test_the_program_says_its_licence(self):
        self.assertIn("licence of this build: Apache-2.0\n", self.root.run("kilotouch --version"))

    def test_a_scene_runs_and_leaves_its_report(self):
        said = self.root.run("kilotouch run /usr/share/kilotouch/scenes/organ_drag.json --out organ && ls organ")
        self.assertRegex(said, r"normal mean 0\.1\d+ N")
        self.assertIn("report.html", said)
        self.assertNotIn("warning", said)

    def test_the_live_page_opens(self):
        self.assertIn("<title>kilotouch", self.root.page("kilotouch view"))
        self.assertIn("<title>kilotouch", self.root.page("python3 -m kilotouch.demo --no-open"))

    def test_programs_are_built_with_the_libraries(self):
        said = self.root.run("cp -r /usr/share/doc/libkilotouch-dev/examples . && cmake -S examples -B made -DCMAKE_BUILD_TYPE=None >/dev/null"
                             " && make -C made press c_loop >/dev/null && cd /usr/share/kilotouch && /root/made/press && /root/made/c_loop")
        self.assertRegex(said, r"0\.5 s: normal 0\.\d*[1-9]\d* N, friction 0\.\d*[1-9]\d* N")

    def test_python_touches_a_body(self):
        said = self.root.run("cd /usr/share/kilotouch && python3 -W error -c 'import kilotouch as kt;"
                             " print(kt.Session(kt.Scene(\"scenes/organ_solid.json\", {\"duration\": 0.2})).run().f_n.max())'")
        self.assertGreater(float(said), 0)

    def test_the_manual_and_the_words_are_there(self):
        said = self.root.run("ls /usr/share/doc/kilotouch-doc/html/docs/scene.html; zcat /usr/share/doc/kilotouch/licences_of_others.gz;"
                             " cat /usr/share/doc/*kilotouch*/copyright")
        self.assertEqual(said.count("Licence of this build as a whole: Apache-2.0."), len(PACKAGES))
        for name in ("libeigen3-dev", "libjs-three", "libboost-dev"):
            self.assertIn("======== " + name, said)

    def test_what_is_purged_leaves_nothing(self):  # the last: tests run in the order of their names
        self.root.run(f"rm -rf /root/*; apt-get purge -q -y {' '.join(PACKAGES)}")
        self.assertEqual(self.root.run("find /usr /etc /var -name '*kilotouch*' ! -path '/var/*/apt/*' ! -path '/var/log/*'"), "")


@unittest.skipUnless(os.geteuid() == 0 and shutil.which("debootstrap"), "a clean root needs root and debootstrap")
class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = Root("python3-venv")
        cls.addClassCleanup(cls.root.remove)
        cls.root.take(*glob.glob(os.path.join(OUT, "*.whl")))
        cls.root.run("python3 -m venv venv && venv/bin/pip install --no-index kilotouch-*.whl")

    def test_nothing_else_is_installed(self):
        said = self.root.run("dpkg-query -W -f '${Package}\\n'; venv/bin/pip list")
        self.assertNotRegex(said, "numpy|libtbb|libembree|libzmq")
        self.assertIn("licence of this build: Apache-2.0\n", self.root.run("venv/bin/kilotouch --version"))

    def test_the_live_page_opens(self):
        self.assertIn("<title>kilotouch", self.root.page("venv/bin/python -m kilotouch.demo --no-open"))

    def test_a_scene_runs(self):
        said = self.root.run("cd venv/lib/python3*/site-packages/kilotouch/share/kilotouch"
                             " && /root/venv/bin/kilotouch run scenes/organ_solid.json --set collision.backend=embree --out /tmp/organ 2>&1;"
                             " ls /tmp/organ")
        self.assertRegex(said, r"normal mean 0\.1\d+ N")
        self.assertIn("trace.csv", said)

    def test_the_module_needs_no_other_package_before_arrays(self):
        said = self.root.run("cd venv/lib/python3*/site-packages/kilotouch/share/kilotouch && /root/venv/bin/python -W error -c 'import"
                             " kilotouch as kt; kt.Session(kt.Scene(\"scenes/organ_solid.json\")); print(kt.__version__, \"ready\")'")
        self.assertRegex(said, r"^0\.\d+\.\d+ ready$")


if __name__ == "__main__":
    unittest.main(verbosity=2, argv=sys.argv)
