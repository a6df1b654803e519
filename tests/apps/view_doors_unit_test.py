#!/usr/bin/env python3
"""Who may do what through the page of kilotouch view: each line of SECURITY.md that is about it, tried from outside."""
import json
import os
import random
import re
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

from view_unit_test import HAS_VIEW, KILOTOUCH, SCENE, SMALL, SOURCE, View, websocket_frame

LIBRARY = "openhaptics"


class Socket:
    """A page's WebSocket."""

    def __init__(self, view, path="/live"):
        status, self.connection, answer = view.upgrade(path)
        if status != 101:
            raise AssertionError(answer)
        self.buffer = answer.partition(b"\r\n\r\n")[2]

    def send(self, **message):
        self.connection.sendall(websocket_frame(json.dumps(message).encode()))

    def take(self, count):
        while len(self.buffer) < count:
            got = self.connection.recv(1 << 20)
            if not got:
                raise EOFError
            self.buffer += got
        out, self.buffer = self.buffer[:count], self.buffer[count:]
        return out

    def frame(self):
        """Opcode and content of the next message."""
        opcode, content = 0, b""
        while True:
            head = self.take(2)
            size = head[1] & 127
            if size >= 126:
                size = struct.unpack(">H" if size == 126 else ">Q", self.take(2 if size == 126 else 8))[0]
            content += self.take(size)
            opcode = opcode or head[0] & 15
            if head[0] & 128:
                return opcode, content

    def until(self, kind, seconds=60, where=lambda message: True):
        """The next message of a type; None: none came in time."""
        end = time.time() + seconds
        while time.time() < end:
            self.connection.settimeout(max(0.01, end - time.time()))
            try:
                opcode, content = self.frame()
            except (socket.timeout, EOFError, ConnectionError):
                return None
            if opcode == 1:
                message = json.loads(content)
                if message["type"] == kind and where(message):
                    return message
        return None

    def ask(self, **message):
        self.send(**message)
        return self.until("answer", 60, lambda answer: answer["to"] == message["type"])


def memory_mb(process):
    with open(f"/proc/{process.pid}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith("VmRSS")) / 1024


def upload(view, name, body):
    own = f"127.0.0.1:{view.port}"
    head = [f"POST /mesh?name={name} HTTP/1.1", f"Host: {own}", f"Origin: http://{own}", f"Content-Length: {len(body)}"]
    connection = socket.create_connection(("127.0.0.1", view.port), 120)
    with connection:
        connection.sendall("\r\n".join(head + ["", ""]).encode() + body)
        answer = connection.recv(65536)
        while b"\r\n\r\n" in answer and not answer.rstrip().endswith(b"}"):
            answer += connection.recv(65536)
        return int(answer.split()[1]), answer.partition(b"\r\n\r\n")[2].decode()


@unittest.skipUnless(HAS_VIEW, "built without kilotouch view")
class Strangers(unittest.TestCase):
    def test_a_body_is_kept_of_nobody_who_is_not_let_in(self):
        with View(SCENE, *SMALL, "--listen", "0.0.0.0", "--token", "open_sesame") as view:
            page = Socket(view, "/live?token=open_sesame")
            self.assertIsNotNone(page.until("status", 120, lambda m: m["refreshes"] > 10))  # the body has what it needs
            before = memory_mb(view.process)
            own = f"127.0.0.1:{view.port}"
            connections = []
            for head in [f"POST /nothing HTTP/1.1\r\nHost: {own}", "POST /mesh?name=a.off&token=open_sesame HTTP/1.1\r\nHost: evil.example",
                         f"POST /mesh?name=a.off HTTP/1.1\r\nHost: {own}\r\nOrigin: http://{own}", f"GET / HTTP/1.1\r\nHost: {own}",
                         f"POST /mesh?name=a.off&token=wrong_word HTTP/1.1\r\nHost: {own}\r\nOrigin: http://{own}"] * 3:
                connection = socket.create_connection(("127.0.0.1", view.port), 10)
                connection.settimeout(2)
                connection.sendall(head.encode() + b"\r\nContent-Length: 63000000\r\n\r\n")
                connections.append(connection)
            for _ in range(30):
                for connection in connections:
                    try:
                        connection.sendall(bytes(1 << 20))
                    except OSError:
                        pass  # it hung up on us
            self.assertLess(memory_mb(view.process) - before, 100)
            for connection in connections:
                connection.close()

    def test_idle_connections_shut_nobody_out(self):
        with View(SCENE, *SMALL) as view:
            idle = [socket.create_connection(("127.0.0.1", view.port), 10) for _ in range(150)]
            half = [socket.create_connection(("127.0.0.1", view.port), 10) for _ in range(50)]
            for connection in half:
                connection.sendall(b"GET / HTTP/1.1\r\nHost: ")
            page = Socket(view)
            self.assertIsNotNone(page.until("status"))
            self.assertEqual(view.request(["GET / HTTP/1.1", f"Host: 127.0.0.1:{view.port}"])[0], 200)
            self.assertIsNotNone(page.until("status"))  # a page that is open stays
            for connection in idle + half:
                connection.close()

    @unittest.skipUnless(hasattr(os, "geteuid") and os.geteuid() == 0, "only root can act as another user")
    def test_another_user_of_this_computer_needs_a_token(self):
        ask = ("import socket,sys;s=socket.create_connection(('127.0.0.1',int(sys.argv[1])),10);"
               "s.sendall(('GET /%s HTTP/1.1\\r\\nHost: localhost:1\\r\\n\\r\\n'%sys.argv[2]).encode());print(s.recv(1000).split()[1].decode())")

        def status_for(view, user, path=""):
            return subprocess.run([shutil.which("python3", path="/usr/bin:/bin") or sys.executable, "-c", ask, str(view.port), path], capture_output=True, text=True, user=user, check=True).stdout.strip()

        with View(SCENE, *SMALL) as view:
            self.assertEqual(status_for(view, 0), "200")
            self.assertEqual(status_for(view, 65534), "403")
        with View(SCENE, *SMALL, "--token", "open_sesame") as view:
            self.assertEqual(status_for(view, 65534), "200")
            self.assertEqual(view.upgrade()[0], 403)
            self.assertEqual(view.upgrade("/live?token=open_sesame")[0], 101)

    def test_pages_on_another_port_or_behind_another_server_are_served(self):
        with View(SCENE, *SMALL) as view:
            self.assertEqual(view.upgrade(host="localhost:19000")[0], 101)  # ssh -L 19000:localhost:8080
            self.assertEqual(view.upgrade(host="localhost:19000", origin="http://localhost:19001")[0], 403)
            self.assertEqual(view.upgrade(host="robot3:19000")[0], 403)
        with View(SCENE, *SMALL, "--token", "open_sesame") as view:
            self.assertEqual(view.upgrade("/live?token=open_sesame", host="robot3", origin="https://robot3")[0], 101)

    def test_the_page_is_in_no_page_of_others_and_tells_no_address(self):
        with View(SCENE, *SMALL) as view:
            answer = view.request(["GET / HTTP/1.1", f"Host: 127.0.0.1:{view.port}"])[2].decode(errors="replace")
            self.assertIn("frame-ancestors 'none'", answer)
            self.assertIn("Referrer-Policy: no-referrer", answer)

    def test_the_17th_page_is_told_why(self):
        with View(SCENE, *SMALL) as view:
            pages = [Socket(view) for _ in range(16)]
            self.assertIsNotNone(pages[-1].until("hello"))
            opcode, content = Socket(view).frame()
            self.assertEqual((opcode, struct.unpack(">H", content[:2])[0]), (8, 1013))
            self.assertIn(b"16 pages are open", content)

    def test_open_runs_no_shell(self):
        with tempfile.TemporaryDirectory() as folder:
            browser = os.path.join(folder, "xdg-open")
            with open(browser, "w", encoding="ascii") as file:
                file.write('#!/bin/sh\nprintf "%s\\n" "$#" "$1" > "$0.was_given"\n')
            os.chmod(browser, 0o755)
            for listen in ["127.0.0.1", f"::1%'; touch {folder}/pasted; '"]:
                environment = {**os.environ, "PATH": folder + ":" + os.environ["PATH"]}
                run = subprocess.Popen([KILOTOUCH, "view", SCENE, *SMALL, "--port", "0", "--token", "open_sesame", "--open", "--listen", listen],
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=folder, env=environment)
                line = run.stdout.readline()
                end = time.time() + 30
                while "open http" in line and not os.path.exists(browser + ".was_given") and time.time() < end:
                    time.sleep(0.05)
                run.terminate()
                run.communicate(timeout=120)
                self.assertFalse(os.path.exists(os.path.join(folder, "pasted")))
                if listen == "127.0.0.1":
                    with open(browser + ".was_given", encoding="ascii") as file:
                        self.assertEqual(file.read().splitlines(), ["1", line.split()[1]])
                    os.remove(browser + ".was_given")


@unittest.skipUnless(HAS_VIEW, "built without kilotouch view")
class LetIn(unittest.TestCase):
    """What a page that was let in still may not do."""

    def compile(self, source, name, folder):
        compiler = shutil.which("cc")
        if not compiler:
            self.skipTest("no C compiler")
        code = os.path.join(folder, name + ".c")
        with open(code, "w", encoding="ascii") as file:
            file.write(source)
        subprocess.run([compiler, "-shared", "-fPIC", "-o", os.path.join(folder, name), code], check=True)
        return os.path.join(folder, name)

    def marked(self, folder):
        """A library that leaves a file when it is loaded."""
        ran = os.path.join(folder, "ran")
        return ran, self.compile(f'#include <stdio.h>\n__attribute__((constructor)) static void r(void){{FILE*f=fopen("{ran}","w");if(f)fclose(f);}}\n',
                                 "e.so", folder)

    def test_a_page_names_no_library_and_no_address(self):
        with tempfile.TemporaryDirectory() as folder, socket.create_server(("127.0.0.1", 0)) as called:
            ran, library = self.marked(folder)
            address = f"ws://127.0.0.1:{called.getsockname()[1]}"
            called.settimeout(0.5)
            with View(SCENE, *SMALL, "--device", "scene") as view:
                page = Socket(view)
                self.assertIsNotNone(page.until("status"))
                for tool in ["tool", "second_tool"]:
                    for name in ["openhaptics", "forcedimension"]:
                        answer = page.ask(type="restart", settings=[tool + ".path.device=" + json.dumps({"name": name, "library": library})])
                        self.assertIn(tool + ".path.device", answer["error"])
                    answer = page.ask(type="restart", settings=[tool + ".path.device=" + json.dumps({"name": "haply", "address": address})])
                    self.assertIn(tool + ".path.device", answer["error"])
                self.assertFalse(os.path.exists(ran))
                with self.assertRaises(socket.timeout):
                    called.accept()

    def test_a_scene_beside_the_shown_one_names_no_library(self):
        with tempfile.TemporaryDirectory() as folder:
            ran, library = self.marked(folder)
            with open(SCENE, encoding="utf-8") as file:
                scene = file.read().replace("../meshes/", os.path.join(SOURCE, "meshes") + "/")
            for name, path in [("shown", ""), ("full", library), ("relative", "./e.so")]:
                changed = json.loads(re.sub(r"//[^\n]*|/\*.*?\*/", "", scene, flags=re.S))
                if path:
                    changed["tool"]["path"] = {"device": {"name": LIBRARY, "library": path}}
                with open(os.path.join(folder, name + ".json"), "w", encoding="utf-8") as file:
                    json.dump(changed, file)
            with View(os.path.join(folder, "shown.json"), *SMALL, "--device", "scene") as view:
                page = Socket(view)
                self.assertIsNotNone(page.until("status"))
                for name in ["full", "relative"]:
                    self.assertIn("tool.path.device.library", page.ask(type="open", name=name)["error"])
            for command in [["run"], ["view", "--device", "scene", "--port", "0"], ["serve", "--once"], ["advise"]]:
                run = subprocess.run([KILOTOUCH, command[0], os.path.join(folder, "relative.json"), *command[1:]], cwd=folder, capture_output=True, text=True, timeout=60)
                self.assertEqual(run.returncode, 2, run.stdout + run.stderr)
            self.assertFalse(os.path.exists(ran))

    def test_a_session_opens_no_device(self):
        with tempfile.TemporaryDirectory() as folder:
            ran, library = self.marked(folder)
            out = os.path.join(folder, "out")
            subprocess.run([KILOTOUCH, "run", SCENE, "--set", "object.mesh=" + os.path.join(SOURCE, "meshes", "pad.off"), "--set", "local.reducer=condensed",
                            "--set", "duration=0.1", "--no-report", "--quiet", "--out", out], check=True, timeout=300)
            with open(os.path.join(out, "session.json"), encoding="utf-8") as file:
                session = json.load(file)
            session["scene"]["tool"]["path"] = {"device": {"name": LIBRARY, "library": library}}
            with open(os.path.join(out, "session.json"), "w", encoding="utf-8") as file:
                json.dump(session, file)
            subprocess.run([KILOTOUCH, "replay", out], capture_output=True, timeout=300, check=False)
            try:
                with View(out, "--device", "scene") as view:
                    self.assertIsNotNone(Socket(view).until("hello"))
            except AssertionError:
                pass  # refused, which is as good
            self.assertFalse(os.path.exists(ran))

    def test_a_page_sees_no_file_of_the_server(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ["private.txt", "private.off"]:
                with open(os.path.join(folder, name), "w", encoding="ascii") as file:
                    file.write("secret-word-4711 and more\n")
            with View(SCENE, *SMALL) as view:
                page = Socket(view)
                self.assertIsNotNone(page.until("status"))
                told = set()
                for key, name in [("tool.path.recording", "private.txt"), ("object.mesh", "private.off"), ("tool.mesh", "private.off"),
                                  ("object.mesh", "nothing.off")]:
                    settings = [key + "=" + os.path.join(folder, name)] + (["tool.shape=mesh"] if key == "tool.mesh" else [])
                    error = page.ask(type="restart", settings=settings)["error"]
                    self.assertIn(key, error)
                    self.assertNotIn("4711", error)
                    told.add(error.split('"')[2])
                self.assertEqual(len(told), 1)  # the same whether the file is there or not

    def test_a_page_sees_no_words_of_a_file_in_the_scenes_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(SCENE, encoding="utf-8") as file:
                scene = file.read().replace("../meshes/organ.off", os.path.join(SOURCE, "meshes", "pad.off"))
            files = {"s.json": scene, "words.txt": "secret-4711, of, mine, alone\n1,2,3,4\n", "number.txt": "17 secret-4711 3 4\n",
                     "row.csv": "t,x,y,z\n0,0,0,0\n1,0,0,secret-4711\n", "mesh.off": "OFF\n3 1 0\n0 0 secret-4711\n"}
            for name, content in files.items():
                with open(os.path.join(folder, name), "w", encoding="ascii") as file:
                    file.write(content)
            with View(os.path.join(folder, "s.json"), *SMALL[2:]) as view:
                page = Socket(view)
                self.assertIsNotNone(page.until("status"))
                for name, line in (("words.txt", 1), ("number.txt", 1), ("row.csv", 3), ("mesh.off", 3)):
                    key = "object.mesh" if name == "mesh.off" else "tool.path.recording"
                    error = page.ask(type="restart", settings=[f"{key}={name}"])["error"]
                    self.assertIn(f"{name}:{line}: is no ", error)
                    self.assertNotIn("4711", error)

    def test_a_device_is_closed_before_it_is_opened_again(self):
        source = """
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
static int is_open;
static void note(const char* s) { FILE* f = fopen(getenv("DHD_NOTES"), "a"); fprintf(f, "%s\\n", s); fclose(f); }
int dhdGetDeviceCount(void) { return 1; }
int dhdOpenID(char id) { if (is_open) { note("twice"); return -1; } is_open = 1; note("open"); return 0; }
int dhdClose(char id) { struct timespec t = {0, 300000000}; nanosleep(&t, 0); is_open = 0; note("closed"); return 0; }
const char* dhdGetSystemName(char id) { return "omega.3"; }
int dhdGetSerialNumber(unsigned short* o, char id) { *o = 1; return 0; }
_Bool dhdHasWrist(char id) { return 0; }
_Bool dhdHasActiveWrist(char id) { return 0; }
int dhdEnableForce(unsigned char on, char id) { note(on ? "on" : "off"); return 0; }
int dhdSetGravityCompensation(int a, char b) { return 0; }
double dhdGetMaxForce(char id) { return -1; }
int dhdGetPosition(double* x, double* y, double* z, char id) { struct timespec t = {0, 900000}; nanosleep(&t, 0); *x = *y = 0; *z = 0.05; return 0; }
int dhdGetOrientationFrame(double m[3][3], char id) { memset(m, 0, 72); m[0][0] = m[1][1] = m[2][2] = 1; return 0; }
int dhdGetLinearVelocity(double* x, double* y, double* z, char id) { *x = *y = *z = 0; return 0; }
unsigned dhdGetButtonMask(char id) { return 0; }
int dhdGetStatus(int* o, char id) { memset(o, 0, 17 * sizeof(int)); o[3] = 1; o[5] = 1; return 0; }
int dhdSetForce(double x, double y, double z, char id) { return 0; }
int dhdSetForceAndTorqueAndGripperForce(double x, double y, double z, double a, double b, double c, double g, char id) { return 0; }
const char* dhdErrorGetLastStr(void) { return "in use"; }
"""
        with tempfile.TemporaryDirectory() as folder:
            library = self.compile(source, "libdhd.so", folder)
            os.environ["DHD_NOTES"] = os.path.join(folder, "notes")
            device = json.dumps({"name": "forcedimension", "library": library})
            with View(SCENE, *SMALL, "--set", "tool.path.device=" + device, "--device", "scene") as view:
                page = Socket(view)
                self.assertIsNotNone(page.until("status", 60, lambda m: m["ticks"] > 50))
                for mu in ["0.2", "0.3"]:
                    self.assertEqual(page.ask(type="restart", settings=["contact.mu=" + mu])["error"], "")
                    self.assertIsNotNone(page.until("status", 60, lambda m: m["ticks"] > 50 and not m["error"]))
            with open(os.environ["DHD_NOTES"], encoding="ascii") as file:
                notes = [line for line in file.read().split() if line in ("open", "closed", "twice")]
            self.assertEqual(notes, ["open", "closed"] * 3)

    def test_pictures_come_while_a_mesh_is_looked_at(self):
        noise = random.Random(1)
        count = 60000
        corners = ("%.4f %.4f %.4f\n" % (noise.random(), noise.random(), noise.random()) for _ in range(3 * count))
        soup = (f"OFF\n{3 * count} {count} 0\n" + "".join(corners) + "".join(f"3 {3 * i} {3 * i + 1} {3 * i + 2}\n" for i in range(count))).encode()
        with View(SCENE, *SMALL) as view:
            page = Socket(view)
            self.assertIsNotNone(page.until("status", 60, lambda m: m["refreshes"] > 5))
            answers = []
            drop = threading.Thread(target=lambda: answers.append(upload(view, "soup.off", soup)))
            start = time.time()
            drop.start()
            longest, last, busy = 0, time.time(), 0
            while drop.is_alive():
                if page.until("status", 0.5):
                    longest, last = max(longest, time.time() - last), time.time()
                if not busy and time.time() - start > 1.5 and drop.is_alive():
                    busy = upload(view, "second.off", b"OFF\n")[0]  # one at a time
            took = time.time() - start
            if took > 4:
                self.assertEqual(busy, 503)
                self.assertLess(longest, 0.6 * took)
            self.assertIn(answers[0][0], (200, 400))

    def test_what_is_wrong_with_a_dropped_mesh_names_no_folder_of_the_server(self):
        with View(SCENE, *SMALL) as view:
            status, said = upload(view, "bad.off", b"OFF\n1 1 0\n0 0 zero\n")
            self.assertEqual(status, 400)
            error = json.loads(said)["error"]
            self.assertTrue(error.startswith("bad.off"), error)
            self.assertNotIn("\\n", error)
            self.assertNotIn(tempfile.gettempdir(), error)
            with open(os.path.join(SOURCE, "meshes", "pad.off"), "rb") as file:
                self.assertEqual(upload(view, "my%20pad.off", file.read())[0], 200)
            page = Socket(view)
            self.assertIsNotNone(page.until("hello"))
            page.send(type="open", name="dropped mesh")
            hello = page.until("hello", 60)
            self.assertIn("my pad.off", hello["title"])
            self.assertNotIn(tempfile.gettempdir(), json.dumps(hello))
            self.assertEqual(upload(view, "a" * 300 + ".off", b"OFF\n")[0], 400)

    def test_names_that_are_no_utf8_are_shown(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = os.fsencode(folder) + b"/b\xff.json"
            with open(SCENE, encoding="utf-8") as file:
                text = file.read().replace("../meshes/", os.path.join(SOURCE, "meshes") + "/")
            with open(scene, "w", encoding="utf-8") as file:
                file.write(text)
            with View(os.fsdecode(scene), *SMALL) as view:
                page = Socket(view)
                hello = page.until("hello")
                self.assertEqual(hello["scenes"], ["b\\xff"])
                self.assertEqual(page.ask(type="open", name="b\\xff")["error"], "")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[1:], verbosity=2)
