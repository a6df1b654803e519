#!/usr/bin/python3
"""Wrong files, keys and values: each ends with exit code 2 and exactly one line that says what, where and what is allowed.

The table is docs/errors.md: `bad_input_unit_test.py --write` writes it, a test compares it. KILOTOUCH names the program.
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from patience import PATIENCE

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
MANUAL = os.path.join(ROOT, "docs", "errors.md")
BROKEN = ("empty", "truncated", "index_out_of_range", "wrong_count", "nan", "open", "self_intersecting", "inside_out",
          "nonmanifold_edge")


SCENE = '{"object": {"mesh": "ball.off"}, "duration": 0.01}'
FILES = {  # made for the cases below
    "ball.off": None,  # copied from meshes/
    "ball.json": SCENE,
    "garbage.off": bytes(range(256)) * 4,
    "utf16.obj": "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".encode("utf-16"),
    "header.off": "FFO\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    "garbage.stl": b"\0" * 80 + (4000000000).to_bytes(4, "little") + b"\0" * 50,
    "short.ply": "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n",
    "._ball.off": b"\0\5\x16\7\0\2\0\0Mac OS X        ",
    "large.obj": "v 0 0 0\nv 1e200 0 0\nv 0 1 0\nf 1 2 3\n",
    "brick.mesh": "MeshVersionFormatted 2\nDimension 3\nVertices\n1\n0 0 0 0\nHexahedra\n0\nEnd\n",
    "lz4.vtu": '<VTKFile type="UnstructuredGrid" compressor="vtkLZ4DataCompressor">\n</VTKFile>\n',
    "words.obj": "v 0 0 0\nv 1 0 0\nv 0 1 O\nf 1 2 3\n",
    "mesh.xyz": "0 0 0\n",
    "comma.json": '{"object": {"mesh": "ball.off",}}',
    "twice.json": '{"object": {"mesh": "ball.off"}, "seed": 1, "seed": 2}',
    "key.json": '{"object": {"mesh": "ball.off", "modle": {"young": 1e4}}}',
    "type.json": '{"object": {"mesh": "ball.off"}, "duration": "long"}',
    "list.json": "[1, 2, 3]",
    "lost.json": '{"object": {"mesh": "lost.off"}}',
    "backwards.csv": "t,x,y,z\n0,0,0,0.1\n0.002,0,0,0.1\n0.001,0,0,0.1\n",
    "words.csv": "t,x,y,z\n0,0,zero,0.1\n",
    "session.json": "{}",
    "occupied": "a file where a folder should go\n",
}


def run_with(*settings):
    return ["run", "ball.json", *(word for s in settings for word in ("--set", s))]


# (what is wrong, arguments, words that the line must hold)
CASES = [
    ("Files", [
        ("no such file", ["mesh", "info", "lost.off"], ["lost.off", "no such file"]),
        ("a folder", ["mesh", "info", "folder.off"], ["folder.off", "directory"]),
        ("0 bytes", ["mesh", "info", "empty.off"], ["empty.off", "0 bytes"]),
        ("binary garbage", ["mesh", "info", "garbage.off"], ["garbage.off:1", "OFF"]),
        ("UTF-16 text, as some shells write it", ["mesh", "info", "utf16.obj"], ["utf16.obj", "UTF-16", "UTF-8"]),
        ("wrong header", ["mesh", "info", "header.off"], ["header.off:1", "FFO", "OFF"]),
        ("unknown format", ["mesh", "info", "mesh.xyz"], ["mesh.xyz", ".xyz", ".off"]),
        ("the file ends early", ["mesh", "info", "truncated.off"], ["truncated.off:", "ends"]),
        ("index out of range", ["mesh", "info", "index_out_of_range.off"], ["index_out_of_range.off:9", "7", "0..3"]),
        ("two thousand million vertices announced", ["mesh", "info", "wrong_count.off"], ["wrong_count.off:", "2000000000"]),
        ("a letter O for a zero", ["mesh", "info", "words.obj"], ["words.obj:3", '"O"']),
        ("a coordinate of 1e200", ["mesh", "info", "large.obj"], ["large.obj:2", '"1e200"', "1e+100"]),
        ("what a Mac keeps beside a file", ["mesh", "info", "._ball.off"], ["._ball.off", "Mac", "AppleDouble"]),
        ("cells that are not read", ["mesh", "info", "brick.mesh"], ["brick.mesh:6", "Hexahedra", "Tetrahedra"]),
        ("compressed in another way", ["mesh", "info", "lz4.vtu"], ["lz4.vtu:1", "vtkLZ4DataCompressor", "vtkZLibDataCompressor"]),
        ("joining nodes over a whole mesh", ["mesh", "repair", "ball.off", "--weld", "1"], ["--weld", "1", "longest side"]),
        ("coordinate NaN", ["mesh", "tet", "nan.off"], ["nan.off:", "nan", "finite"]),
        ("PLY: fewer vertices than announced", ["mesh", "info", "short.ply"], ["short.ply"]),
        ("STL: four thousand million triangles announced", ["mesh", "info", "garbage.stl"], ["garbage.stl", "4000000000"]),
    ]),
    ("Surfaces that cannot be filled", [
        ("open", ["mesh", "tet", "open.off"], ["open.off", "open", "places", "repair"]),
        ("crosses itself", ["mesh", "tet", "self_intersecting.off"], ["crosses itself", "triangle", "--wrap"]),
        ("inside out", ["mesh", "tet", "inside_out.off"], ["inside out", "repair"]),
        ("three triangles on an edge", ["mesh", "tet", "nonmanifold_edge.off"], ["three or more triangles", "--wrap"]),
        ("unknown backend", ["mesh", "tet", "ball.off", "--backend", "tetgn"], ["tetgn", "tetgen", "netgen", "cgal"]),
        ("quality below 1", ["mesh", "tet", "ball.off", "--quality", "0"], ["quality", "0", "1.1"]),
        ("a count below 0", ["mesh", "info", "ball.off", "--places", "-1"], ["--places", "-1", "0"]),
    ]),
    ("Scene files", [
        ("no such scene", ["run", "lost_scene.json"], ["lost_scene.json", "no such"]),
        ("a folder", ["run", "folder.off"], ["folder.off", "folder", "session.json"]),
        ("a mesh that is none", ["run", "header.off"], ["header.off:1", "OFF"]),
        ("neither scene nor mesh", ["run", "mesh.xyz"], ["mesh.xyz", ".json", ".off", "folder of a run"]),
        ("a comma too many", ["run", "comma.json"], ["comma.json:1:", "comma"]),
        ("no group { }", ["run", "list.json"], ["list.json", "group"]),
        ("a key twice", ["run", "twice.json"], ["twice.json", "seed", "twice"]),
        ("unknown key", ["run", "key.json"], ["key.json", "object.modle", "did you mean model"]),
        ("text for a number", ["run", "type.json"], ["type.json", "duration", "long", "number"]),
        ("its mesh is missing", ["run", "lost.json"], ["lost.off", "no such file"]),
    ]),
    ("Devices", [
        ("an unknown device", run_with("tool.path.device.name=hapli"), ["tool.path.device.name", "hapli", "haply"]),
        ("a device without a name", run_with("tool.path.device={}"), ["tool.path.device", "name"]),
        ("a pointer without a page", run_with("tool.path.device.name=pointer"), ["pointer", "kilotouch view"]),
        ("a device whose service does not run", run_with("tool.path.device.name=haply",
                                                         "tool.path.device.address=ws://localhost:7"),
         ["tool.path.device", "ws://localhost:7", "refused", "Haply Inverse Service"]),
        ("a device whose library is missing", run_with("tool.path.device.name=forcedimension",
                                                       "tool.path.device.library=/none/libdhd.so"),
         ["tool.path.device", "/none/libdhd.so", "tool.path.device.library"]),
        ("left-handed axes", run_with("tool.path.device.name=haply", "tool.path.device.axes=YXZ"),
         ["tool.path.device.axes", "YXZ", "left-handed"]),
        ("an axis twice", run_with("tool.path.device.name=haply", "tool.path.device.axes=XXZ"),
         ["tool.path.device.axes", "XXZ", "twice"]),
        ("more force than any device gives", run_with("tool.path.device.name=haply", "tool.path.device.max_force=41"),
         ["tool.path.device.max_force", "41", "at most 40"]),
        ("a coupling that is a word", run_with("tool.path.device.name=haply", "tool.path.device.coupling=soft"),
         ["tool.path.device.coupling", "soft"]),
        ("a pushed device where nobody pushes", run_with("tool.path.device.name=pushed"), ["pushed", "nobody pushes"]),
        ("an unknown device to test", ["device", "test", "hapli"], ["hapli", "haply"]),
        ("nothing to test", ["device", "test"], ["device test", "--machine"]),
        ("a wall of no stiffness", ["device", "test", "haply", "--wall", "0"], ["--wall", "0", "1 .. 5000"]),
        ("an address of another kind", ["device", "test", "haply", "--address", "localhost"], ["localhost", "ws://HOST:PORT"]),
        ("advice with a device", ["advise", "ball.json", "--set", "tool.path.device.name=haply"],
         ["tool.path.device", "recording"]),
    ]),
    ("Two computers", [
        ("a body elsewhere, for a command that runs it many times", ["advise", "ball.json", "--set", "link.type=network"], ["link.type network", "lockstep"]),
        ("an address without a port that is one", ["serve", "ball.json", "--listen", "127.0.0.1:http"],
         ["--listen", "127.0.0.1:http", "0 .. 65535"]),
        ("open to others without keys", ["serve", "ball.json", "--listen", "0.0.0.0:0"],
         ["--listen", "0.0.0.0", "kilotouch key new", "--keys"]),
        ("a list of hands without keys of its own", ["serve", "ball.json", "--authorized", "ball.json"],
         ["--authorized", "--keys"]),
        ("keys that are not there", ["serve", "ball.json", "--keys", "none"], ["none"]),
        ("a method whose models cannot travel", ["serve", "ball.json", "--set", "local.method=hold"],
         ["link.type network", "local.method", "hold", "multirate"]),
        ("another computer without keys", ["touch", "192.0.2.1:7700"], ["192.0.2.1", "--keys", "--server-key"]),
        ("an unknown device of the hand", ["touch", "127.0.0.1:7", "--device", "hapli"], ["device", "hapli", "haply"]),
        ("half of the keys", ["touch", "127.0.0.1:7", "--server-key", "0" * 40], ["--keys", "--server-key", "together"]),
        ("a stale time that is too short", run_with("link.stale_ms=1"), ["link.stale_ms", "1", "at least 20"]),
        ("bits that no basis has", run_with("link.basis_bits=12"), ["link.basis_bits", "12", "8", "16"]),
    ]),
    ("Values", [
        ("negative stiffness", run_with("object.model.young=-5"), ["object.model.young", "-5", "above 0"]),
        ("Poisson's ratio 0.5", run_with("object.model.poisson=0.5"), ["object.model.poisson", "0.5", "below 0.5"]),
        ("rate 0", run_with("local.rate_hz=0"), ["local.rate_hz", "0", "at least 10"]),
        ("global rate above the local one", run_with("global.rate_hz=2000"), ["global.rate_hz", "2000", "local.rate_hz"]),
        ("self-contact from a negative distance on", run_with("global.self_contact.reach=-1e-4"),
         ["global.self_contact.reach", "-0.0001", "above 0"]),
        ("self-contact with steps that jump over it", run_with("global.self_contact={}", "global.integrator=sdirk2"),
         ["global.integrator", "sdirk2", "newton_euler"]),
        ("self-contact of a surface that crosses itself",
         run_with("global.self_contact={}", "object.layers.thickness=0.002", "object.mesh=self_intersecting.off"),
         ["global.self_contact", "self_intersecting.off", "12 pairs", "triangles"]),
        ("kinetic friction above static", run_with("contact.mu_static=0.2", "contact.mu_kinetic=0.4"),
         ["contact.mu_kinetic", "0.4", "mu_static"]),
        ("a negative Stribeck velocity", run_with("contact.stribeck=-0.1"), ["contact.stribeck", "-0.1", "at least 0"]),
        ("an unknown contact surface", run_with("contact.surface=smooth"), ["contact.surface", "smooth", "flat", "loop"]),
        ("a smooth surface of no level", run_with("contact.surface=loop", "contact.surface_levels=0"),
         ["contact.surface_levels", "0", "at least 1"]),
        ("a smooth surface under a law that knows none", run_with("contact.surface=loop", "contact.law=paper_stick"),
         ["contact.surface", "loop", "paper_stick", "flat"]),
        ("a region without friction", run_with("contact.regions=[{\"box\":[[0,0,0],[1,1,1]]}]"),
         ["contact.regions[0]", "mu"]),
        ("a region's box inside out", run_with("contact.regions=[{\"box\":[[0,0,1],[1,1,0]],\"mu\":1}]"),
         ["contact.regions[0].box", "max below its min"]),
        ("a sphere without radius", run_with("tool.radius=0"), ["tool.radius", "0", "above 0"]),
        ("a tool that is none", run_with("tool.shape=cone"), ["tool.shape", "cone", "capsule"]),
        ("a capsule of no length", run_with("tool.shape=capsule", "tool.length=0"), ["tool.length", "0", "above 0"]),
        ("a capsule under a law that knows none", run_with("tool.shape=capsule", "contact.law=paper_stick"),
         ["tool.shape", "capsule", "paper_stick"]),
        ("a second tool under a law that knows one", run_with("second_tool={}", "contact.law=paper_stick"),
         ["second_tool", "paper_stick", "coulomb"]),
        ("a second tool with a method that knows one", run_with("second_tool={}", "local.method=hold"),
         ["second_tool", "hold", "multirate"]),
        ("a second tool without radius", run_with("second_tool.radius=0"), ["second_tool.radius", "0", "above 0"]),
        ("a mesh tool without a mesh", run_with("tool.shape=mesh"), ["tool.mesh", "file"]),
        ("a mesh tool that is not there", run_with("tool.shape=mesh", "tool.mesh=lost_tool.off"), ["lost_tool.off", "no such file"]),
        ("a mesh for a tool that is none", run_with("tool.mesh=ball.off"), ["tool.mesh", "sphere"]),
        ("times not increasing", run_with("tool.path.waypoints=[[0,0,0,1],[2,0,0,1],[1,0,0,1]]"),
         ["tool.path.waypoints[2]", "increase"]),
        ("unknown reducer", run_with("local.reducer=wal"), ["local.reducer", "wal", "did you mean", "full"]),
        ("unknown law", run_with("contact.law=colomb"), ["contact.law", "colomb", "did you mean", "coulomb"]),
        ("unknown method", run_with("local.method=frozn"), ["local.method", "frozn", "did you mean", "frozen", "hold"]),
        ("a law that is a method, with another", run_with("contact.law=penalty", "local.method=hold"),
         ["contact.law", "penalty", "local.method", "hold", "coulomb"]),
        ("a law that a method cannot use", run_with("contact.law=paper_stick", "local.method=frozen"),
         ["local.method", "frozen", "paper_stick", "coulomb"]),
        ("no wall", run_with("local.method=legacy", "local.reducer=full"), ["local.method", "legacy", "wall", "full"]),
        ("no spring", run_with("contact.penalty.stiffness=0"), ["contact.penalty.stiffness", "0", "above 0"]),
        ("unknown model", run_with("object.model.type=fem2"), ["object.model.type", "fem2", "msd"]),
        ("unknown material", run_with("object.model.type=fem", "object.model.material=neo_hokean"),
         ["object.model.material", "neo_hokean", "neo_hookean"]),
        ("an inclusion without a size", run_with('object.model.inclusions=[{"center":[0,0,0],"radius":0,"stiffer":5}]'),
         ["object.model.inclusions[0].radius", "0", "above 0"]),
        ("an inclusion of no stiffness", run_with('object.model.inclusions=[{"center":[0,0,0],"radius":0.01,"stiffer":-5}]'),
         ["object.model.inclusions[0].stiffer", "-5", "above 0"]),
        ("an inclusion with a key that is none", run_with('object.model.inclusions=[{"center":[0,0,0],"radios":0.01,"stiffer":5}]'),
         ["object.model.inclusions[0].radios", "did you mean radius", "center"]),
        ("an inclusion without a factor", run_with('object.model.inclusions=[{"center":[0,0,0],"radius":0.01}]'),
         ["object.model.inclusions[0].stiffer", "missing"]),
        ("an inclusion beside the body",
         run_with('object.model.inclusions=[{"center":[0,0,0],"radius":0.01,"stiffer":5},{"center":[0,0,0.1],"radius":0.01,"stiffer":5}]'),
         ["object.model.inclusions[1]", "(0, 0, 0.1)", "0.01 m", "no element", "-0.03", "0.03"]),
        ("unknown element", run_with("object.model.element=tet8"), ["object.model.element", "tet8", "tet4", "tet10"]),
        ("gravity with two numbers", run_with("object.gravity=[0,-9.81]"), ["object.gravity", "3"]),
        ("unknown solver", run_with("global.solver=cholmod"), ["global.solver", "cholmod", "direct"]),
        ("unknown collision backend", run_with("collision.backend=embre"), ["collision.backend", "embre", "embree"]),
        ("unknown integrator", run_with("global.integrator=euler"), ["global.integrator", "euler", "implicit_euler"]),
        ("unknown local integrator", run_with("local.integrator=euler"), ["local.integrator", "euler", "implicit_euler"]),
        ("unknown tetrahedralizer", run_with("object.tetrahedralize.backend=tetgn"),
         ["object.tetrahedralize.backend", "tetgn", "tetgen"]),
        ("unknown link", run_with("link.type=wifi"), ["link.type", "wifi", "lockstep", "thread"]),
        ("a metric the law cannot use", run_with("contact.metric=identity"), ["contact.metric", "identity", "implicit"]),
        ("a clamped node that is not there", run_with("object.fixed.nodes=[99999]"), ["object.fixed.nodes", "99999", "0 .. "]),
        ("a clamping box beside the body", run_with("object.fixed.box=[[5,5,5],[6,6,6]]"), ["object.fixed.box", "no node"]),
        ("pressing beside the body", run_with("tool.path.press_drag.at=[1,1]"), ["tool.path.press_drag.at", "misses"]),
        ("a recording that is missing", run_with("tool.path.recording=lost.csv"), ["lost.csv"]),
        ("a recording with a word", run_with("tool.path.recording=words.csv"), ["words.csv:2", "zero"]),
        ("a recording that goes back", run_with("tool.path.recording=backwards.csv"), ["backwards.csv:4", "0.001"]),
        ("springs that are neither given nor calibrated", run_with("object.model.calibrate=false"), ["calibrate", "stiffness"]),
        ("a unit that is none", run_with("object.scale=mn"), ["object.scale", '"mn"', "mm"]),
        ("no value", run_with("contact.mu"), ["contact.mu", "key=value"]),
    ]),
    ("Commands and outputs", [
        ("unknown command", ["rnu", "ball.json"], ["rnu", "did you mean", "run"]),
        ("unknown command of mesh", ["mesh", "inof", "ball.off"], ["mesh", "inof", "info"]),
        ("unknown option", ["run", "ball.json", "--outt", "x"], ["run", "--outt", "did you mean", "--out"]),
        ("nothing to run", ["run"], ["run", "WHAT", "--help"]),
        ("a reference coarser than the run", ["run", "ball.json", "--reference", "--reference-rate", "500"],
         ["--reference-rate", "500", "local.rate_hz", "1000"]),
        ("a reference that is missing", ["run", "ball.json", "--reference-file", "lost.csv"], ["--reference-file", "lost.csv"]),
        ("a reference of a body that touches itself",
         ["run", "ball.json", "--reference", "--set", "global.self_contact={}"], ["--reference", "global.self_contact"]),
        ("advice on a body that touches itself", ["advise", "ball.json", "--set", "global.self_contact={}"],
         ["advise", "global.self_contact"]),
        ("advice on two tools", ["advise", "ball.json", "--set", "second_tool={}"], ["advise", "second_tool"]),
        ("a folder that cannot be made", ["run", "ball.json", "--out", "occupied/result"], ["occupied/result"]),
        ("a file in a folder that is not there", ["run", "ball.json", "--json", "nowhere/s.json"], ["nowhere/s.json"]),
        ("mesh written where no folder is", ["mesh", "info", "ball.off", "-o", "nowhere/a.off"], ["nowhere/a.off", "folder"]),
        ("mesh written in an unknown format", ["mesh", "repair", "ball.off", "-o", "a.xyz"], ["a.xyz", ".off"]),
        ("a surface that is split too finely", ["run", "ball.json", "--set", "object.tetrahedralize.max_edge=1e-6"],
         ["max_edge", "1e-06", "200000 nodes"]),
        ("a map that is none", ["stability", "time_stap"], ["unknown map", "time_step", "poisson"]),
        ("advice within no error at all", ["advise", "ball.json", "--tolerance", "0"], ["--tolerance", "0", "above 0"]),
        ("advice in no time", ["advise", "ball.json", "--budget-seconds", "0"], ["--budget-seconds", "0", "1 .."]),
        ("advice on a method of another kind", ["advise", "ball.json", "--set", "contact.law=penalty"],
         ["advise", "local.method", "penalty"]),
        ("advice on a tool that does not touch", ["advise", "ball.json", "--budget-seconds", "900", "--set", "tool.path.press_drag.depth=0"],
         ["advise", "press"]),
        ("no session to replay", ["replay", "lost_session"], ["lost_session"]),
        ("not a session", ["replay", "session.json"], ["session.json", "scene"]),
        ("a folder to compare that is not there", ["compare", "lost_run", "other_run"], ["lost_run", "no such folder"]),
        ("one run to compare", ["compare", "lost_run"], ["RUN", "2"]),
        ("a check of nothing", ["check"], ["PATH"]),
        ("a check of what is not there", ["check", "nowhere"], ["nowhere"]),
        ("a part that does not exist", ["check", "ball.off", "--shard", "3/2"], ["3/2", "1 .. N"]),
    ]),
]


def make_files(folder):
    for name, content in FILES.items():
        if content is not None:
            mode, encoding = ("wb", None) if isinstance(content, bytes) else ("w", "utf-8")
            with open(os.path.join(folder, name), mode, encoding=encoding) as file:
                file.write(content)
    shutil.copy(os.path.join(ROOT, "meshes", "sphere.off"), os.path.join(folder, "ball.off"))
    for name in BROKEN:
        shutil.copy(os.path.join(ROOT, "meshes", "broken", name + ".off"), folder)
    os.mkdir(os.path.join(folder, "folder.off"))


def run(folder, arguments):
    return subprocess.run([PROGRAM, *arguments], cwd=folder, capture_output=True, text=True, errors="replace", timeout=PATIENCE)


def is_whole_build():
    """Every backend is there; else some lines name other backends."""
    with tempfile.TemporaryDirectory() as folder:
        run(folder, ["list", "--json", "list.json"])
        with open(os.path.join(folder, "list.json"), encoding="utf-8") as file:
            return all(b["available"] for family in json.load(file).values() for b in family)


def shell(arguments):
    return "kilotouch " + " ".join(f"'{a}'" if re.search(r"[\[\]{} ]", a) else a for a in arguments)


def manual(lines):
    """docs/errors.md from the line of every case."""
    out = ["# Wrong input and what it says", "",
           "Wrong input ends with exit code 2 and one line on stderr. This page is made by", "",
           "    python3 tests/apps/bad_input_unit_test.py --write", "",
           "and a test compares it with what the program says. `ball.json` is a scene with `meshes/sphere.off`; the faulty files are",
           "described in the headings and made by that script."]
    for title, cases in CASES:
        out += ["", f"## {title}", ""]
        for what, arguments, _ in cases:
            out += [f"**{what}**", "", f"    $ {shell(arguments)}", f"    {lines[tuple(arguments)]}", ""]
        out.pop()
    return "\n".join(out) + "\n"


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        make_files(cls.temporary.name)
        cls.whole = is_whole_build()
        cls.lines = {}
        for _, cases in CASES:
            for what, arguments, words in cases:
                cls.lines[tuple(arguments)] = run(cls.temporary.name, arguments)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_each_case_is_one_line_and_exit_code_2(self):
        for _, cases in CASES:
            for what, arguments, words in cases:
                with self.subTest(what):
                    result = self.lines[tuple(arguments)]
                    # Without CGAL nothing sees that a surface crosses itself before TetGen crashes on it (exit code 1).
                    codes = [2] if self.whole or what != "crosses itself" else [1, 2]
                    self.assertIn(result.returncode, codes, result.stderr)
                    self.assertRegex(result.stderr, r"\Akilotouch( \w+)*: [^\n]+\n\Z")
                    self.assertLess(len(result.stderr), 500)
                    if self.whole:
                        for word in words:
                            self.assertIn(word, result.stderr)

    def test_nothing_is_left_behind(self):
        known = {*FILES, *(name + ".off" for name in BROKEN), "folder.off"}
        self.assertEqual(set(os.listdir(self.temporary.name)) - known, set())

    def test_the_manual_is_true(self):
        if not self.whole:
            self.skipTest("a backend is not in this build")
        with open(MANUAL, encoding="utf-8") as file:
            self.assertEqual(file.read(), manual(stripped(self.lines)), "run this script with --write")


def stripped(results):
    return {arguments: r.stderr.rstrip("\n") for arguments, r in results.items()}


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        BadInput.setUpClass()
        with open(MANUAL, "w", encoding="utf-8") as file:
            file.write(manual(stripped(BadInput.lines)))
        BadInput.tearDownClass()
    else:
        unittest.main()
