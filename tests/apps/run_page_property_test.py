#!/usr/bin/python3
"""report.html of a run in a browser: it needs nothing else, fits a phone, and the player and the plots share their time.
KILOTOUCH names the program."""
import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest

from patience import PATIENCE

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = None

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
BROWSER = shutil.which("chromium")
NEEDED = [BROWSER or "", "/usr/share/javascript/chart.js/chart.min.js", "/usr/share/javascript/three/three.min.js", "/usr/lib/python3/dist-packages/jinja2", "/usr/lib/python3/dist-packages/matplotlib"]
EVIL = "a <img src=x onerror=document.body.id='P1'> drag"

# Runs in the page after its own scripts, and leaves what it saw as JSON in a text.
LOOK = """
const widthOnly = arguments[0], report = arguments[1], seen = {};
// A while, and until what it brought is drawn.
const wait = async ms => { await new Promise(done => setTimeout(done, ms)); await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))); };
(async () => {
  await wait(300);
  const cursor = i => document.querySelectorAll('.cursor')[i].style.transform, readout = () => document.querySelector('.readout').textContent;
  const pixels = () => { const c = document.querySelector('.view canvas'); const g = c.getContext('webgl2') || c.getContext('webgl'); const p = new Uint8Array(4 * c.width * c.height);
                         g.readPixels(0, 0, c.width, c.height, g.RGBA, g.UNSIGNED_BYTE, p); let sum = 0; for (let i = 0; i < p.length; i += 4) if (p[i + 3]) sum = (sum * 31 + p[i] + p[i + 1] + p[i + 2]) % 1e9; return sum; };
  seen.width = [document.documentElement.scrollWidth, innerWidth];
  if (widthOnly) { report(JSON.stringify(seen)); return; }
  seen.charts = document.querySelectorAll('figure.chart').length;
  const slider = document.getElementById('time'), input = v => { slider.value = v; slider.dispatchEvent(new Event('input')); };
  input(100); await wait(100);
  seen.early = [readout(), cursor(0), cursor(1), pixels()];
  input(900); await wait(100);
  seen.late = [readout(), cursor(0), cursor(1), pixels()];
  const plot = document.querySelector('.plot'), box = plot.getBoundingClientRect();
  plot.dispatchEvent(new PointerEvent('pointerdown', {clientX: box.left + box.width / 2, clientY: box.top + 50}));
  await wait(100);
  seen.pressed = [readout(), Number(slider.value), pixels()];
  const count = is => { const c = document.querySelector('.view canvas'); const g = c.getContext('webgl2') || c.getContext('webgl'); const p = new Uint8Array(4 * c.width * c.height);
                        g.readPixels(0, 0, c.width, c.height, g.RGBA, g.UNSIGNED_BYTE, p); let n = 0; for (let i = 0; i < p.length; i += 4) n += is(p[i], p[i + 1], p[i + 2]); return n; };
  const blue = (r, g, b) => b > r + 40, orange = (r, g, b) => r > b + 90 && g > 40, colour = document.getElementById('colour');
  colour.value = 'mode'; colour.dispatchEvent(new Event('change'));
  input(500); await wait(100);
  seen.sticks = [count(blue), count(orange)];
  input(900); await wait(100);
  seen.slips = [count(blue), count(orange)];
  document.getElementById('play').click();
  for (let i = 0; i < 60 && Number(slider.value) < 930; ++i) await wait(100);
  document.getElementById('play').click();
  seen.played = Number(slider.value);
  seen.id = document.body.id;
  report(JSON.stringify(seen));
})();
"""


@unittest.skipUnless(webdriver and all(os.path.exists(path) for path in NEEDED), "needs chromium, python3-selenium, Chart.js, three.js, Jinja2 and matplotlib")
class RunPage(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = cls.temporary.name
        with open(os.path.join(ROOT, "scenes", "organ_springs.json"), encoding="utf-8") as file:
            scene = re.sub(r"//.*", "", file.read()).replace("press and drag on an organ", EVIL).replace("../meshes", os.path.join(ROOT, "meshes"))
        with open(os.path.join(cls.folder, "s.json"), "w", encoding="utf-8") as file:
            file.write(scene)
        subprocess.run([PROGRAM, "run", "s.json", "--set", "duration=0.5", "--set", "local.reducer=condensed", "--out", "o", "--quiet"], cwd=cls.folder, check=True, capture_output=True)
        with open(os.path.join(cls.folder, "o", "report.html"), encoding="utf-8") as file:
            cls.page = file.read()
        options = webdriver.chrome.options.Options()
        for option in ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"]:
            options.add_argument(option)
        cls.browser = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
        cls.browser.set_script_timeout(PATIENCE)

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        cls.temporary.cleanup()

    def look(self, width, height, scale, width_only):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": False})
        self.browser.get("file://" + os.path.join(self.folder, "o", "report.html"))
        return json.loads(self.browser.execute_async_script(LOOK, width_only))

    def test_player_and_plots_share_their_time(self):
        seen = self.look(1400, 1000, 0.5, False)  # a quarter of the pixels: they are drawn without a graphics card
        self.assertLessEqual(*seen["width"])
        self.assertEqual(seen["charts"], 3)
        self.assertEqual(seen["id"], "", "a title was run")
        self.assertIn("t = 0.051 s", seen["early"][0])
        self.assertIn("t = 0.450 s", seen["late"][0])
        self.assertEqual([seen[k][1] == seen[k][2] for k in ("early", "late")], [True, True], "one cursor in both plots")
        self.assertNotEqual(seen["early"][1], seen["late"][1])
        self.assertNotEqual(seen["early"][3], seen["late"][3], "the body is drawn at both times")
        self.assertNotEqual(seen["late"][3], 0)
        self.assertTrue(400 < seen["pressed"][1] < 600, seen["pressed"])  # the middle of the plot
        self.assertNotIn(seen["pressed"][2], (0, seen["late"][3]))
        self.assertGreater(seen["played"], 920)
        self.assertGreater(seen["sticks"][0], 20, seen)
        self.assertGreater(seen["slips"][1], seen["sticks"][1] + 20, seen)
        self.assertLess(seen["slips"][0], 20, seen)

    def test_fits_a_phone(self):
        seen = self.look(390, 844, 1, True)
        self.assertLessEqual(*seen["width"])

    def test_is_small_and_alone(self):
        self.assertLess(len(self.page), 3e6)
        self.assertNotRegex(self.page, r"<script[^>]* src=|<link ")
        self.assertNotIn(EVIL, self.page)


if __name__ == "__main__":
    unittest.main()
