#!/usr/bin/env python3
"""kilotouch view, as a person and as an attacker would use it: a browser drags, sets, records, replays, plays; raw
requests come from elsewhere, without the token, or are nonsense. KT_LONG=1: the same on the organ itself, with every local
model that `auto` certifies, in four times the pixels."""
import base64
import json
import os
import random
import re
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest

from patience import PATIENCE

KILOTOUCH = os.environ["KILOTOUCH"]
SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
SCENE = os.path.join(SOURCE, "scenes", "organ_springs.json")
LONG = os.environ.get("KT_LONG")
# A block of a hundred nodes in place of the organ: nothing here asks for more.
SMALL = [] if LONG else ["--set", "object.mesh=" + os.path.join(SOURCE, "meshes", "pad.off"), "--set", "local.reducer=condensed"]
HAS_VIEW = "built without it" not in subprocess.run([KILOTOUCH, "view", "none.json"], capture_output=True, text=True).stderr

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.support.ui import WebDriverWait
except ImportError:
    webdriver = None


class View:
    """A server of its own, on a port that was free."""

    def __init__(self, what, *options):
        self.folder = tempfile.TemporaryDirectory()
        self.connections = []
        self.process = subprocess.Popen(
            [KILOTOUCH, "view", what, "--port", "0", "--record", os.path.join(self.folder.name, "recordings"), *options],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=self.folder.name)
        self.lines = []
        while True:
            line = self.process.stdout.readline()
            self.lines.append(line)
            found = re.search(r"open (http://\S+)", line)
            if found:
                self.url = found.group(1)
                break
            if not line:
                raise AssertionError("no server: " + "".join(self.lines))
        self.port = int(re.search(r":(\d+)/", self.url).group(1))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for connection in self.connections:
            connection.close()
        self.process.terminate()
        self.process.wait(PATIENCE)  # the body ends the refresh that it is at
        self.process.stdout.close()
        self.folder.cleanup()

    def request(self, head, body=b""):
        """The status of a raw request, and its connection."""
        connection = socket.create_connection(("127.0.0.1", self.port), 10)
        self.connections.append(connection)
        connection.settimeout(PATIENCE)
        connection.sendall("\r\n".join(head + ["", ""]).encode() + body)
        answer = connection.recv(65536)
        return int(answer.split()[1]), connection, answer

    def upgrade(self, path="/live", host=None, origin="own"):
        host = host or f"127.0.0.1:{self.port}"
        head = [f"GET {path} HTTP/1.1", f"Host: {host}", "Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13",
                "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode()]
        if origin is not None:
            head.append("Origin: " + (f"http://{host}" if origin == "own" else origin))
        return self.request(head)


def websocket_frame(payload, opcode=1):
    mask = os.urandom(4)
    size = len(payload)
    head = bytes([0x80 | opcode]) + (bytes([0x80 | size]) if size < 126 else bytes([0x80 | 126]) + struct.pack(">H", size)
                                     if size < 65536 else bytes([0x80 | 127]) + struct.pack(">Q", size))
    return head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload))


@unittest.skipUnless(HAS_VIEW, "built without kilotouch view")
class Access(unittest.TestCase):
    def test_pages_of_others_and_other_names_are_refused(self):
        with View(SCENE, *SMALL) as view:
            self.assertEqual(view.upgrade()[0], 101)
            for origin in ["http://evil.example", "null", None, f"http://127.0.0.1:{view.port + 1}"]:
                self.assertEqual(view.upgrade(origin=origin)[0], 403, origin)
            self.assertEqual(view.upgrade(host=f"evil.example:{view.port}")[0], 403)
            own = f"Host: 127.0.0.1:{view.port}"
            self.assertEqual(view.request(["GET / HTTP/1.1", own])[0], 200)
            self.assertEqual(view.request(["GET /../../etc/passwd HTTP/1.1", own])[0], 404)
            self.assertEqual(view.request(["DELETE / HTTP/1.1", own])[0], 405)
            self.assertEqual(view.request(["POST /mesh?name=a.obj HTTP/1.1", own, "Content-Length: 2"], b"v ")[0], 403)
            own_page = f"Origin: http://127.0.0.1:{view.port}"
            status, _, answer = view.request(["POST /mesh?name=a.exe HTTP/1.1", own, own_page, "Content-Length: 2"], b"v ")
            self.assertEqual(status, 400)
            self.assertIn(b"no mesh file", answer)
            self.assertEqual(view.request(["POST /mesh?name=a.obj HTTP/1.1", own, own_page, f"Content-Length: {65 << 20}"])[0], 413)

    def test_beyond_this_computer_a_token_is_needed(self):
        refused = subprocess.run([KILOTOUCH, "view", SCENE, "--listen", "0.0.0.0", "--port", "0"], capture_output=True, text=True)
        self.assertEqual(refused.returncode, 2)
        self.assertIn("--token", refused.stderr)
        with View(SCENE, *SMALL, "--listen", "0.0.0.0", "--token", "open_sesame") as view:
            self.assertEqual(view.upgrade()[0], 403)
            self.assertEqual(view.upgrade("/live?token=open_sesamf")[0], 403)
            self.assertEqual(view.upgrade("/live?token=open_sesame")[0], 101)

    def test_wrong_use_is_one_line(self):
        for arguments, words in [(["none.json"], "none.json"), ([SCENE, "--port", "70000"], "65535"), ([SCENE, "--device", "mouse"], "pointer"),
                                 ([SCENE, "--token", "a b"], "--token"), ([SCENE, "--set", "contact.mu=x"], "contact.mu")]:
            run = subprocess.run([KILOTOUCH, "view", *arguments], capture_output=True, text=True, timeout=PATIENCE)
            self.assertEqual((run.returncode, run.stderr.count("\n")), (2, 1), run.stderr)
            self.assertIn(words, run.stderr)

    def test_record_says_at_once_where_nothing_can_be_written(self):
        with View(SCENE, *SMALL) as view:
            with open(os.path.join(view.folder.name, "recordings"), "w", encoding="utf-8"):
                pass  # a file in the folder's place
            connection = view.upgrade()[1]
            connection.sendall(websocket_frame(b'{"type":"record","on":true}'))
            got, end = b"", time.monotonic() + PATIENCE
            while b"cannot make the folder" not in got and time.monotonic() < end:
                got = got[-200:] + connection.recv(65536)
            self.assertIn(b"cannot make the folder", got)
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "file")
            with open(file, "w", encoding="utf-8"):
                pass
            run = subprocess.run([KILOTOUCH, "view", SCENE, "--record", file], capture_output=True, text=True, timeout=PATIENCE)
            self.assertEqual((run.returncode, run.stderr.count("\n")), (2, 1), run.stderr)
            self.assertIn("--record", run.stderr)

    def test_nonsense_neither_ends_it_nor_stalls_the_tick(self):
        noise = random.Random(1)
        with View(SCENE, *SMALL) as view:
            seeds = [b'{"type":"target","x":[0,0,0.05],"number":1,"stamp":1}', b'{"type":"set","settings":["contact.mu=0.5"]}',
                     b'{"type":"record","on":true}', b'{"type":"open","name":"../../etc/passwd"}', b'{"type":"restart","settings":["a=b"]}']
            for round_ in range(6):
                connection = view.upgrade()[1]
                try:
                    for _ in range(60):
                        message = bytearray(noise.choice(seeds))
                        for _ in range(noise.randrange(4)):
                            message[noise.randrange(len(message))] = noise.randrange(256)
                        connection.sendall(websocket_frame(bytes(message), noise.choice([1, 1, 1, 2])))
                    connection.sendall([websocket_frame(b"[" * 60000), websocket_frame(b"x" * 70000), os.urandom(500)][round_ % 3])
                    time.sleep(0.2)
                except OSError:
                    pass  # it hung up on us
                connection.close()
            time.sleep(0.5)
            self.assertIsNone(view.process.poll())
            self.assertEqual(view.upgrade()[0], 101)


@unittest.skipUnless(HAS_VIEW, "built without kilotouch view")
@unittest.skipIf(webdriver is None, "python3-selenium and chromium are not installed")
class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        options = webdriver.chrome.options.Options()
        for option in ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                       "--window-size=1000,700", f"--force-device-scale-factor={0.5 if LONG else 0.25}", "--disable-dev-shm-usage"]:
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.browser = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()

    def wait(self, script, seconds=PATIENCE):
        return WebDriverWait(self.browser, seconds, 0.2).until(lambda b: b.execute_script("return " + script), script)

    def open(self, url):
        self.browser.get(url)
        self.wait("kilotouch.view.frame && kilotouch.state.hello")

    def force(self):
        return self.browser.execute_script("return kilotouch.view.frame.tools[0].f_n")

    def press(self):
        # On the body where it is at rest, as a person would: the middle of its picture.
        ActionChains(self.browser, duration=20).move_to_element_with_offset(self.browser.find_element("id", "view"), 0, 0).click().perform()
        self.wait("kilotouch.view.frame.tools[0].f_n > 0.02")

    def message(self):
        return self.browser.find_element("id", "message").text

    def test_touch_set_record_replay_and_play(self):
        with View(SCENE, *SMALL) as view:
            self.open(view.url)
            self.browser.get_log("browser")  # of the tests before
            self.assertEqual(self.force(), 0)
            self.browser.find_element("id", "record").click()
            self.wait("kilotouch.state.status && kilotouch.state.status.recording")
            self.press()
            # The cursor and the tool are apart: the spring between them holds the force.
            apart = self.browser.execute_script("const f = kilotouch.view.frame; return Math.hypot(...f.target.map((v, i) => v - f.tools[0].x[i]))")
            self.assertGreater(apart, 1e-5)
            before = self.browser.execute_script("return kilotouch.state.status.settings['contact.mu']")
            # A slider, in steps of the keyboard.
            slider = self.browser.find_element("css selector", "#controls input[type=range]")
            slider.send_keys("\ue014" * 5)  # arrow right
            self.wait(f"kilotouch.state.status.settings['contact.mu'] !== '{before}'")
            field = self.browser.find_element("id", "setting")
            field.send_keys("contact.mu=-1\n")
            self.wait("document.getElementById('message').className === 'bad'")
            self.assertIn("contact.mu", self.message())
            field.clear()
            field.send_keys("contact.mus=1\n")
            self.wait("document.getElementById('message').textContent.includes('contact.mus')")
            self.assertFalse(self.browser.execute_script("return document.getElementById('ask').open"), "told before it is asked")
            self.assertIn("did you mean", self.message())
            # Drag over the surface.
            self.browser.find_element("id", "lift").click()
            self.wait("kilotouch.view.frame.tools[0].f_n === 0")
            drag = ActionChains(self.browser, duration=100).move_to_element_with_offset(self.browser.find_element("id", "view"), -20, 0).click_and_hold()
            drag.perform()
            self.wait("kilotouch.view.frame.tools[0].f_n > 0.02")
            for step in range(8):
                ActionChains(self.browser, duration=100).move_by_offset(6, 0).perform()
            self.wait("kilotouch.view.frame.tools[0].f_n > 0")  # a picture may show it as it hops
            ActionChains(self.browser).release().perform()
            self.browser.find_element("id", "record").click()
            self.wait("document.getElementById('message').textContent.startsWith('recorded in')")
            folder = re.search(r"recorded in (\S+?);", self.message()).group(1)
            errors = [line for line in self.browser.get_log("browser") if line["level"] == "SEVERE"]
            self.assertEqual(errors, [])
            with open(os.path.join(folder, "session.json"), encoding="utf-8") as file:
                session = json.load(file)
            self.assertGreaterEqual(len(session["setting_changes"]), 1)
            replay = subprocess.run([KILOTOUCH, "replay", folder], capture_output=True, text=True, timeout=PATIENCE)
            self.assertIn("bit for bit", replay.stdout, replay.stderr)
            with View(folder) as player:
                self.open(player.url)
                self.assertEqual(self.browser.execute_script("return kilotouch.state.hello.mode"), "session")
                self.wait("kilotouch.state.duration > 0.5")
                most = self.browser.execute_script("const v = kilotouch.plot.values; let m = 0; for (let i = 0; i < v.length; i += 3) m = Math.max(m, v[i]); return m")
                self.assertGreater(most, 0.02)
                self.browser.execute_script("window.atStart = Array.from(kilotouch.view.x)")
                self.browser.find_element("id", "play").click()
                self.wait("kilotouch.state.time > 0.3")
                # However long the tool was in the air before: where the machine is busy, the press comes late.
                self.wait("kilotouch.view.x.some((v, i) => v !== atStart[i])")
                self.wait("kilotouch.view.frame.t > 0.25")

    def test_a_second_page_watches_until_it_takes_the_tool(self):
        with View(SCENE, *SMALL) as view:
            self.open(view.url)
            self.wait("kilotouch.state.status && kilotouch.state.status.has_tool")
            first = self.browser.current_window_handle
            self.browser.switch_to.new_window("tab")
            self.open(view.url)
            self.wait("kilotouch.state.status && !kilotouch.state.status.has_tool")
            self.browser.execute_script("send({type: 'reset'})")
            self.wait("document.getElementById('message').textContent.includes('another page has the tool')")
            self.browser.find_element("id", "take").click()
            self.wait("kilotouch.state.status.has_tool")
            self.browser.close()
            self.browser.switch_to.window(first)

    def test_a_mesh_that_is_dropped_is_looked_at_and_opened(self):
        with View(SCENE, *SMALL) as view, tempfile.TemporaryDirectory() as folder:
            self.open(view.url)
            mesh = os.path.join(folder, "ball.off")
            with open(os.path.join(SOURCE, "meshes", "organ.off"), encoding="utf-8") as organ:
                text = organ.read()
            with open(mesh, "w", encoding="utf-8") as out:
                out.write(text)
            self.browser.find_element("id", "file").send_keys(mesh)
            self.wait("document.querySelector('#findings button')")
            self.assertIn("642 nodes", self.browser.find_element("id", "findings").text)
            self.browser.find_element("css selector", "#findings button").click()
            self.wait("kilotouch.state.hello.title.includes('dropped')", PATIENCE)
            bad = os.path.join(folder, "bad.off")
            with open(bad, "w", encoding="utf-8") as out:
                out.write("OFF\n1 1 0\n0 0 zero\n")
            self.browser.find_element("id", "file").send_keys(bad)
            self.wait("document.getElementById('findings').textContent.includes('zero')")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[1:], verbosity=2)
