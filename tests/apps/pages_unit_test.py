#!/usr/bin/python3
"""The pages of the manual: each is in the navigation, and its code is code. KILOTOUCH names the program; without it commands are not tried."""
import ast
import fnmatch
import importlib.util
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
sys.path.insert(0, os.path.join(ROOT, "scripts", "manual_parts"))
import scene_keys
import stage

PAGES = [p for p in stage.pages_of(ROOT) if p != "CHANGELOG.md"]
HAS_SPHINX = all(importlib.util.find_spec(name) for name in ("sphinx", "furo", "myst_parser"))


def text_of(page):
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        return file.read()


def blocks(page):
    """[(line, language, code)] of fenced and indented blocks."""
    out, code, language, fenced, prose = [], [], "", False, False
    for number, line in enumerate(text_of(page).split("\n") + [""], 1):
        if line.strip().startswith("```"):
            if fenced:
                out.append((begin, language, "\n".join(code)))
            fenced, language, code, begin, prose = not fenced, line.strip()[3:], [], number + 1, False
        elif fenced:
            code.append(line)
        elif line.startswith("    ") and not prose:
            begin = begin if code else number
            code.append(line[4:])
        else:
            if code:
                out.append((begin, "", "\n".join(code)))
            code, prose = [], bool(line.strip())
    return out


def json_of(code):
    """Of JSON with comments; a group without its braces is one of a scene."""
    bare = re.sub(r"/\*.*?\*/", "", re.sub(r'("(?:[^"\\]|\\.)*")|//[^\n]*', lambda m: m[1] or "", code), flags=re.S)
    return json.loads(bare if bare.lstrip().startswith(("{", "[")) else "{" + bare.strip().rstrip(",") + "}")


def commands(code):
    """Words of each line that calls the program; what stands behind two blanks or # explains it."""
    for line in re.sub(r"\\\n\s*", "", code).split("\n"):
        m = re.match(r"(?:\$ )?(?:\S+=\S+ )*(?:build/release/)?kilotouch (.*)", line)
        if m:
            words = re.split(r"\s{2,}|\s#", m[1])[0].split(" && ")[0].split(" | ")[0]
            try:
                yield line, shlex.split(words)
            except ValueError:
                pass


class Pages(unittest.TestCase):
    def test_each_page_of_the_manual_is_in_the_navigation(self):
        with open(os.path.join(ROOT, "scripts", "manual_parts", "navigation.json"), encoding="utf-8") as file:
            patterns = [p for _, part in json.load(file) for p in part]
        left = [p for p in PAGES if p.startswith("docs/") and p != "docs/index.md" and not any(fnmatch.fnmatch(p, q) for q in patterns)]
        self.assertEqual(left, [])
        for pattern in patterns:
            self.assertTrue(pattern.startswith("docs/reference/") or fnmatch.filter(PAGES + ["CHANGELOG.md"], pattern), pattern)

    def test_prose_gets_no_worse(self):
        done = subprocess.run([os.path.join(ROOT, "scripts", "prose"), "--ceilings"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, f"{done.stderr}see scripts/prose --help")

    def test_notebooks_are_those_of_the_tutorials(self):
        done = subprocess.run([os.path.join(ROOT, "scripts", "notebook"), "--check"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_python_and_json_are_whole(self):
        found = 0
        for page in PAGES:
            for line, language, code in blocks(page):
                with self.subTest(f"{page}:{line}"):
                    if language == "python":
                        ast.parse(code)
                        found += 1
                    elif language == "json":
                        json_of(code)
                        found += 1
        self.assertGreater(found, 3)

    def test_pictures_load_nothing_from_elsewhere(self):
        for name in os.listdir(os.path.join(ROOT, "docs", "pictures")):
            if name.endswith(".svg"):
                self.assertNotRegex(text_of(os.path.join("docs", "pictures", name)).replace("http://www.w3.org/2000/svg", ""), "https?:")

    def test_the_fields_of_scenes_are_those_of_the_schema(self):
        done = subprocess.run([os.path.join(ROOT, "scripts", "scene_fields"), "--check"], capture_output=True, text=True)
        self.assertEqual((done.stderr, done.returncode), ("", 0))

    def test_keys_for_experts_stand_apart_in_the_manual(self):
        schema = json.loads(text_of("io/scene/scene.schema.json"))
        expert = {key for key, s in scene_keys.leaves(schema, schema) if s.get("expert")}
        part = text_of("docs/scene.md").split("## Keys for experts")[1].split("\n## ")[0]
        self.assertEqual(expert, set(re.findall(r"^\| `([a-z_.]+)` \|", part, re.MULTILINE)))

    @unittest.skipUnless(os.access(PROGRAM, os.X_OK), "needs the program")
    def test_commands_exist_with_their_options_keys_and_files(self):
        schema = json.loads(text_of("io/scene/scene.schema.json"))
        keys = {key for key, _ in scene_keys.leaves(schema, schema)}
        groups = {key.rsplit(".", n)[0] for key in keys for n in range(1, key.count(".") + 1)}
        helps, found = {}, 0
        for page in PAGES:
            if page == "docs/errors.md":  # wrong on purpose; compared with the program by a test of its own
                continue
            for number, _, code in blocks(page):
                for line, words in commands(code):
                    where = f"{page}:{number}: {line}"
                    command = tuple(words[:2] if words[0] in ("mesh", "device", "key") else words[:1])
                    if command[0].startswith("-") or "…" in line or "..." in words:
                        continue
                    if command not in helps:
                        helps[command] = subprocess.run([PROGRAM, *command, "--help"], capture_output=True, text=True)
                    if helps[command].returncode != 0 and "`kilotouch " + " ".join(command) + "`" in text_of("docs/command_line.md"):
                        continue  # a command that this build lacks
                    self.assertEqual(helps[command].returncode, 0, where)
                    options = set(re.findall(r"(?<![\w-])--?[A-Za-z][\w-]*", helps[command].stdout))
                    found += 1
                    for before, word in zip(words, words[1:]):
                        if word.startswith("-") and len(word) > 1 and not word[1].isdigit():
                            self.assertIn(word.split("=")[0], options, where)
                        elif before == "--set" and "=" in word:
                            self.assertTrue(word.split("=")[0] in keys | groups, where)
                        elif re.match(r"(scenes|meshes)/.*\.\w+$", word):
                            self.assertTrue(os.path.exists(os.path.join(ROOT, word)), where)
        self.assertGreater(found, 60)

    @unittest.skipUnless(HAS_SPHINX, "needs scripts/setup --manual")
    def test_the_site_is_made_without_warnings_and_loads_nothing_from_elsewhere(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, os.path.join(ROOT, "scripts", "manual"), "--strict", "--out", folder,
                                   "--build", os.path.dirname(PROGRAM)], capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            pages = 0
            for at, _, names in os.walk(os.path.join(folder, "html")):
                for name in names:
                    if name.endswith((".html", ".css")):
                        with open(os.path.join(at, name), encoding="utf-8") as file:
                            text = file.read()
                        pages += name.endswith(".html")
                        elsewhere = re.search(r"<(?:script|img|iframe)[^>]*\ssrc=\"(?:https?:)?//|<link[^>]*stylesheet[^>]*href=\"(?:https?:)?//|"
                                              r"url\([\"']?(?:https?:)?//|@import[^;]*", text)
                        self.assertIsNone(elsewhere, f"{name}: {elsewhere and elsewhere[0]}")
        self.assertGreater(pages, 30)


if __name__ == "__main__":
    unittest.main(verbosity=2, argv=sys.argv)
