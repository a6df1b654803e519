#!/usr/bin/env python3
"""kilotouch view: what is set and recorded over a page's socket."""
import json
import os
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from view_socket import PageSocket  # noqa: E402
from view_unit_test import HAS_VIEW, KILOTOUCH, SCENE, SMALL, View  # noqa: E402


@unittest.skipUnless(HAS_VIEW, "built without kilotouch view")
class Settings(unittest.TestCase):
    def live(self, page, *keys):
        return [float(page.status["settings"][key]) for key in keys]

    def test_a_restart_keeps_what_was_set_and_checks_against_it(self):
        keys = ("contact.mu_static", "contact.mu_kinetic", "object.model.young", "tool.radius")
        with View(SCENE, *SMALL) as view:
            page = PageSocket(view).runs()
            for setting in ("contact.mu = 0.9", "object.model.young=20000", " tool.radius =0.006", "contact.mu_kinetic=0.7"):
                self.assertEqual(page.ask(type="set", settings=[setting])["error"], "", setting)
            page.until(lambda: self.live(page, *keys) == [0.9, 0.7, 20000, 0.006])
            # Against the value that it runs with, not the file's 0.5.
            self.assertIn("0.9", page.ask(type="set", settings=["contact.mu_kinetic=1"])["error"])
            before, page.hello = page.hello, None
            page.send(type="restart", settings=["object.model.poisson=0.4"])
            page.until(lambda: page.hello)
            page.runs()
            self.assertEqual(self.live(page, *keys), [0.9, 0.7, 20000, 0.006])
            self.assertEqual(page.hello["scene"]["object"]["model"]["poisson"], 0.4)
            self.assertNotEqual(before["scene"]["object"]["model"]["poisson"], 0.4)
            # The kinetic coefficient follows the static one down, and so it does in the next body.
            self.assertEqual(page.ask(type="set", settings=["contact.mu_static=0.3"])["error"], "")
            page.hello = None
            page.send(type="restart", settings=["object.model.poisson=0.3"])
            page.until(lambda: page.hello)
            page.runs()
            self.assertEqual(self.live(page, *keys), [0.3, 0.3, 20000, 0.006])

    def test_what_is_set_while_the_next_body_is_built_is_set_in_it(self):
        with View(SCENE, *SMALL) as view:
            page = PageSocket(view).runs()
            page.hello = None
            page.send(type="restart", settings=["object.model.poisson=0.4"])
            page.send(type="set", settings=["contact.mu=0.8"])
            page.until(lambda: page.hello)
            page.runs()
            page.until(lambda: self.live(page, "contact.mu") == [0.8])

    def test_a_body_that_takes_minutes_to_fill_can_be_given_up(self):
        with View(SCENE, *SMALL) as view:
            page = PageSocket(view).runs()
            error = page.ask(type="restart", settings=["object.tetrahedralize.max_volume=1e-18"])["error"]
            self.assertIn("must be at least", error)  # more than the mesher's memory holds: refused at once
            self.assertIn("no body is being built", page.ask(type="cancel")["error"])
            hello, count = page.hello, len(page.answers)
            page.send(type="restart", settings=["object.tetrahedralize.max_volume=5e-11"])
            time.sleep(1.5)
            self.assertEqual(len(page.answers), count)
            self.assertTrue(self.children(view))
            start = time.time()
            answer = page.ask(type="cancel")
            self.assertEqual((answer["to"], answer["error"]), ("restart", "cancelled: the body before stays"))
            self.assertLess(time.time() - start, 10)
            self.assertEqual(self.children(view), [])
            self.assertIs(page.hello, hello)
            page.send(type="restart", settings=["object.model.poisson=0.4"])  # the next one is built
            page.until(lambda: page.hello is not hello)
            page.runs()
            page.send(type="restart", settings=["object.tetrahedralize.max_volume=5e-11"])
            time.sleep(0.5)
            start = time.time()  # the end of the server does not wait for a mesher either
        self.assertLess(time.time() - start, 10)

    def children(self, view):
        with open(f"/proc/{view.process.pid}/task/{view.process.pid}/children", encoding="ascii") as file:
            own = file.read().split()
        for task in os.listdir(f"/proc/{view.process.pid}/task"):
            with open(f"/proc/{view.process.pid}/task/{task}/children", encoding="ascii") as file:
                own += file.read().split()
        return own

    def test_what_a_restart_would_refuse_is_told_beforehand(self):
        with View(SCENE, *SMALL) as view:
            page = PageSocket(view).runs()
            hello = page.hello
            for setting, words in (("object.model.poison=0.4", "did you mean"), ("object.model.poisson=0.7", "0.7"), ("nothing", "KEY=VALUE")):
                answer = page.ask(type="check", settings=[setting])
                self.assertEqual(answer["to"], "check")
                self.assertIn(words, answer["error"] if words != "KEY=VALUE" else "KEY=VALUE")
                self.assertNotEqual(answer["error"], "")
            self.assertEqual(page.ask(type="check", settings=["object.model.poisson = 0.4"])["error"], "")
            self.assertIs(page.hello, hello)  # nothing was built

    def test_blanks_around_a_setting_do_not_count(self):
        out = subprocess.run([KILOTOUCH, "run", SCENE, *SMALL, "--set", " contact.mu = 0.75 ", "--set", "duration=0.01", "--no-report"], capture_output=True, text=True,
                             timeout=300)
        self.assertEqual(out.returncode, 0, out.stderr)
        wrong = subprocess.run([KILOTOUCH, "run", SCENE, *SMALL, "--set", "contact.mu = -1"], capture_output=True, text=True, timeout=60)
        self.assertEqual((wrong.returncode, wrong.stderr.count("\n")), (2, 1))
        self.assertIn("--set contact.mu = -1", wrong.stderr)


@unittest.skipUnless(HAS_VIEW, "built without kilotouch view")
class Recording(unittest.TestCase):
    def test_its_clock_runs_from_the_first_tick_that_is_kept(self):
        with View(SCENE, *SMALL) as view:
            page = PageSocket(view).runs()
            self.assertIsNone(page.status["recorded_s"])
            page.send(type="record", on=True)
            page.until(lambda: page.status["recording"])
            page.until(lambda: page.status and page.status["recorded_s"] is not None)
            page.until(lambda: page.status["recorded_s"] > 0.4)
            told = page.status["recorded_s"]
            answer = page.ask(type="record", on=False)
            self.assertEqual(answer["error"], "")
            with open(os.path.join(answer["what"], "session.json"), encoding="utf-8") as file:
                session = json.load(file)
            self.assertGreaterEqual(session["scene"]["duration"], told - 1e-9)

    def test_it_can_be_taken_back_before_it_has_begun(self):
        with View(SCENE, *SMALL) as view:
            page = PageSocket(view).runs()
            page.send(type="record", on=True)
            page.send(type="record", on=False)
            page.until(lambda: page.status["recorded_s"] is None and not page.status["recording"])
            page.runs()
            time.sleep(0.5)
            page.until(lambda: page.status)
            self.assertFalse(page.status["recording"])
            self.assertEqual([a for a in page.answers if a["to"] == "record" and not a["error"]], [])


@unittest.skipUnless(HAS_VIEW, "built without kilotouch view")
class Doors(unittest.TestCase):
    def test_forwarded_ports_and_proxies(self):
        """ssh -L and docker -p: another port in Host. With a token any name, and https where a proxy has TLS."""
        with View(SCENE, *SMALL) as view:
            for host in ("localhost:19000", "127.0.0.1:1", "localhost", "[::1]:8080"):
                self.assertEqual(view.request(["GET / HTTP/1.1", f"Host: {host}"])[0], 200, host)
                self.assertEqual(view.upgrade(host=host)[0], 101, host)
            self.assertEqual(view.upgrade(host="localhost:19000", origin="http://localhost:19001")[0], 403)
            for host in ("robot3:19000", "localhost.evil.example:8080"):
                self.assertEqual(view.request(["GET / HTTP/1.1", f"Host: {host}"])[0], 403, host)
        with View(SCENE, *SMALL, "--listen", "0.0.0.0", "--token", "open_sesame") as view:
            for host in (f"localhost:{view.port}", "localhost:19000", "robot3:19000", "robot3"):
                self.assertEqual(view.request(["GET /?token=open_sesame HTTP/1.1", f"Host: {host}"])[0], 200, host)
                self.assertEqual(view.upgrade("/live?token=open_sesame", host=host)[0], 101, host)
                self.assertEqual(view.upgrade("/live?token=open_sesame", host=host, origin=f"https://{host}")[0], 101, host)
                self.assertEqual(view.upgrade("/live", host=host)[0], 403, host)

    def test_the_seventeenth_page_is_told_why(self):
        with View(SCENE, *SMALL) as view:
            pages = [PageSocket(view) for _ in range(16)]
            pages[-1].until(lambda: pages[-1].status)
            late = PageSocket(view)
            late.until(lambda: late.closed)
            self.assertEqual(late.closed[0], 1013)
            self.assertIn("16 pages are open", late.closed[1])
            pages[0].connection.close()
            pages[-1].until(lambda: pages[-1].status["pages"] == 15)
            again = PageSocket(view)
            again.until(lambda: again.hello)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[1:], verbosity=2)
