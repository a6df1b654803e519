#!/usr/bin/python3
"""The gallery: its page, figures and pictures are those of its scenes, and each scene starts and ends. KILOTOUCH names the program."""
import glob
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
from importlib.machinery import SourceFileLoader

from patience import PATIENCE

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
SHORT = "duration=0.05"  # [s] touches nothing in most scenes: set-up, first local models and the end are tried

loader = SourceFileLoader("gallery", os.path.join(ROOT, "scripts", "gallery"))
gallery = importlib.util.module_from_spec(importlib.util.spec_from_loader("gallery", loader))
loader.exec_module(gallery)


def figures():
    with open(gallery.FIGURES, encoding="utf-8") as file:
        return json.load(file)


class Gallery(unittest.TestCase):
    def test_every_scene_of_the_folder_is_in_it(self):
        shown = {scene for _, scene, _, _ in gallery.SCENES}
        self.assertLessEqual({os.path.relpath(f, ROOT) for f in glob.glob(os.path.join(ROOT, "scenes", "gallery", "*.json"))}, shown)
        for scene in shown:
            self.assertTrue(os.path.exists(os.path.join(ROOT, scene)), scene)

    def test_figures_and_pictures_are_of_its_scenes(self):
        names = {name for name, *_ in gallery.SCENES}
        self.assertEqual(set(figures()), names)
        self.assertEqual({os.path.splitext(f)[0] for f in os.listdir(gallery.PICTURES) if f.endswith(".webp")}, names)

    def test_the_page_is_made_from_the_figures(self):
        with open(gallery.PAGE, encoding="utf-8") as file:
            self.assertEqual(file.read(), gallery.page(figures()), "scripts/gallery --figures makes it")

    def test_each_finding_against_a_force_is_told(self):
        for name, figure in figures().items():
            told = "\n".join(gallery.told(figure))
            self.assertEqual(figure["trusted"], not figure["findings"], name)
            for finding in figure["findings"]:
                self.assertIn(finding["what"], told, name)
            about_the_body = any((f["where"] or "").startswith("object") for f in figure["findings"])
            self.assertFalse(about_the_body and "times the force of the continuum" in told.split("\n")[0], name)

    @unittest.skipUnless(os.access(PROGRAM, os.X_OK), "needs the program")
    def test_each_scene_starts_and_ends(self):
        for name, scene, *_ in gallery.SCENES:
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                done = subprocess.run([PROGRAM, "run", os.path.join(ROOT, scene), "--set", SHORT, "--out", folder, "--no-report", "-q"],
                                      capture_output=True, text=True, timeout=PATIENCE)
                self.assertEqual(done.returncode, 0, done.stderr)
                with open(os.path.join(folder, "summary.json"), encoding="utf-8") as file:
                    self.assertEqual(json.load(file)["ticks"]["total"], 50)


if __name__ == "__main__":
    unittest.main()
