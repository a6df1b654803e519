#!/usr/bin/env python3
"""The page of kilotouch view in a browser: what fits, what its chip says, what is drawn where, and what is left of it without WebGL."""
import os
import sys
import tempfile
import unittest

from patience import PATIENCE

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from view_unit_test import HAS_VIEW, SCENE, SMALL, SOURCE, Service, View, WebDriverWait, webdriver  # noqa: E402


@unittest.skipUnless(HAS_VIEW, "built without kilotouch view")
@unittest.skipIf(webdriver is None, "python3-selenium and chromium are not installed")
class Browser(unittest.TestCase):
    options = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]

    @classmethod
    def setUpClass(cls):
        options = webdriver.chrome.options.Options()
        for option in ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-background-networking", *cls.options]:
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        cls.browser = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
        cls.view = View(SCENE, *SMALL)

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        cls.view.__exit__()

    def run_script(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def wait(self, script, seconds=180):
        return WebDriverWait(self.browser, seconds, 0.2).until(lambda b: b.execute_script("return " + script), script)

    def open(self, width=1200, height=1000):
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 0.25, "mobile": False})
        self.browser.get(self.view.url)
        self.wait("kilotouch.view.frame && kilotouch.state.status && kilotouch.state.status.refreshes > 3")


class Layout(Browser):
    def test_a_desktop_shows_all_of_it_at_once(self):
        self.open()
        page = "const p = document.documentElement, a = document.querySelector('aside');"
        self.assertEqual(self.run_script(page + "return [p.scrollHeight - innerHeight, p.scrollWidth - innerWidth]"), [0, 0])
        self.assertLessEqual(self.run_script(page + "return a.scrollHeight - a.clientHeight"), 0)
        # Settings come before anything that is only looked at.
        top = lambda name: self.run_script("return document.getElementById(arguments[0]).getBoundingClientRect().top", name)
        self.assertLess(top("settings"), 400)
        for name in ("record", "reset", "pause", "settings", "other"):
            self.assertLess(top(name), 960, name)

    def test_a_phone_has_the_buttons_on_the_screen_and_nothing_beside_it(self):
        self.open(390, 844)
        box = "const b = document.getElementById(arguments[0]).getBoundingClientRect(); return [b.left, b.top, b.right, b.bottom]"
        for y in (0, 10000):  # wherever it is scrolled to
            self.run_script("scrollTo(0, arguments[0])", y)
            for name in ("pause", "reset", "record", "lift"):
                left, top, right, bottom = self.run_script(box, name)
                self.assertTrue(0 <= left < right <= 390 and 0 <= top < bottom <= 844, (name, left, top, right, bottom))
        self.assertEqual(self.run_script("return document.documentElement.scrollWidth > innerWidth"), False)

    def test_the_field_of_the_file_lies_in_its_frame(self):
        self.open()
        inside = self.run_script("const b = n => document.getElementById(n).getBoundingClientRect(), f = b('file'), d = b('drop');"
                                 "return f.top >= d.top - 1 && f.bottom <= d.bottom + 1 && f.left >= d.left - 1 && f.right <= d.right + 1")
        self.assertTrue(inside)


class States(Browser):
    def test_the_chip_has_three_states(self):
        self.open()
        chip = lambda **status: self.run_script("return chipOf({...kilotouch.state.status, error: '', paused: false, refreshes: 9, ...arguments[0]})", status)
        self.assertEqual(chip(real_time="yes"), ["good", "real time"])
        self.assertEqual(chip(real_time="just about"), ["good", "real time"])
        self.assertEqual(chip(real_time="no", refresh_hz=12, wanted_hz=30), ["late", "late: 12 of 30 refreshes a second"])
        self.assertEqual(chip(real_time="no", refresh_hz=30, wanted_hz=30)[0], "late")
        self.assertEqual(chip(error="TetGen failed")[0], "stopped")
        self.assertEqual(chip(paused=True)[0], "wait")
        self.assertEqual(chip(refreshes=1)[0], "wait")
        # What it means is behind a click, and out of the way until then.
        self.assertFalse(self.run_script("return document.getElementById('about').checkVisibility()"))
        self.browser.find_element("css selector", "#chip summary").click()
        self.assertTrue(self.run_script("return document.getElementById('about').checkVisibility()"))
        self.assertIn("refreshes a second", self.browser.find_element("id", "about").text)

    def test_a_recording_says_when_it_begins(self):
        self.open()
        told = lambda **status: self.run_script("showRecording({recording: true, ...arguments[0]}); const c = document.getElementById('clip');"
                                                "return [!c.hidden, c.textContent, document.getElementById('record').textContent]", status)
        self.assertEqual(told(recording=False, recorded_s=None)[0], False)
        self.assertIn("starts", told(recorded_s=None)[1])
        self.assertEqual(told(recorded_s=None)[2], "Cancel")
        self.assertEqual(told(recorded_s=3.25)[1:], ["recording 3.3 s", "Stop, save"])

    def test_a_setting_may_have_blanks_and_an_unknown_key_is_told_before_anything_is_asked(self):
        self.open()
        field = self.browser.find_element("id", "setting")
        field.send_keys(" contact.mu = 0.7\n")
        self.wait("kilotouch.state.status.settings['contact.mu'] === '0.7'")
        field.clear()
        field.send_keys("contact.mus = 1\n")
        self.wait("document.getElementById('message').textContent.includes('did you mean')")
        self.assertFalse(self.run_script("return document.getElementById('ask').open"))
        field.clear()
        field.send_keys("object.model.poisson = 0.4\n")
        self.wait("document.getElementById('ask').open")
        self.assertIn("object.model.poisson", self.browser.find_element("id", "question").text)
        self.browser.find_element("css selector", "#ask button").click()

    def test_a_body_that_is_being_built_has_a_button_to_give_it_up(self):
        self.open()
        self.browser.find_element("id", "setting").send_keys("object.tetrahedralize.max_volume = 5e-11\n")
        self.wait("document.getElementById('ask').open")
        self.browser.find_element("css selector", "#ask .strong").click()
        self.wait("document.getElementById('cancel')").click()
        self.wait("document.getElementById('message').textContent === 'cancelled: the body before stays'")

    def test_the_socket_is_beside_the_page_whatever_its_address(self):
        self.open()
        self.assertTrue(self.run_script("return addressOf('live').href").startswith(self.view.url))
        self.assertEqual(self.run_script("return new URL('live', 'https://host/lab/body/?token=a').href"), "https://host/lab/body/live")
        source = self.run_script("return connect.toString()")
        self.assertIn("'wss:'", source)


class Drawing(Browser):
    def test_scales_hold_still(self):
        self.open()
        tops = self.run_script("""const s = new HeldScale(0.05), out = [];
            for (const [v, t] of [[0.01, 0], [0.3, 1], [0.45, 2], [0.2, 3], [0.1, 4], [0.1, 8], [0.1, 9.5], [0.1, 30]]) out.push(s.hold(v, t));
            return out""")
        self.assertEqual(tops, [0.05, 0.5, 0.5, 0.5, 0.5, 0.5, 0.1, 0.1])

    def test_only_what_is_touched_is_painted_and_the_arrow_begins_on_the_tool(self):
        self.open()
        press = self.browser.find_element("id", "view")
        webdriver.ActionChains(self.browser, duration=20).move_to_element_with_offset(press, 0, 0).click().perform()
        self.wait("kilotouch.view.frame.tools[0].f_n > 0.02")
        self.run_script("const c = document.getElementById('colour'); c.value = 'mode'; c.dispatchEvent(new Event('change'))")
        self.wait("kilotouch.view.contacts[0].visible")
        # In one go: the body moves on.
        painted, patch, furthest, away, radius, mode, colour = self.run_script("""
            const v = kilotouch.view, t = v.frame.tools[0], shown = v.tools[0], at = v.contacts[0].geometry.attributes.position, n = v.contacts[0].geometry.drawRange.count;
            const touched = v.touched(shown, t), corner = i => [0, 1, 2].map(c => v.x[3 * i + c]);
            let furthest = 0;
            for (const k of touched.slice(0, -1)) for (let c = 0; c < 3; ++c) furthest = Math.max(furthest, Math.hypot(...corner(v.triangles[3 * k + c]).map((x, i) => x - t.x[i])));
            v.update(v.frame, {});
            const start = v.forces[0].object.position, from = v.frame.tools[0];
            return [n / 3, v.patch.size, furthest, Math.hypot(start.x - from.x[0], start.y - from.x[1], start.z - from.x[2]), shown.radius, t.mode, '#' + v.contacts[0].material.color.getHexString().toUpperCase()]""")
        self.assertGreater(painted, 0)
        self.assertLess(painted, 0.5 * patch)
        self.assertLess(furthest, 1.05 * radius)
        self.assertAlmostEqual(away, radius, delta=0.1 * radius)
        self.assertEqual(colour, {1: "#56B4E9", 2: "#8C8C8C", 3: "#E69F00"}[mode])

    def test_clamped_nodes_axes_and_a_length_are_shown(self):
        self.open()
        nodes, clamped = self.run_script("const v = kilotouch.view; return [v.x.length / 3, v.clamped.geometry.attributes.position.count]")
        self.assertTrue(0 < clamped < nodes)
        self.assertEqual(self.run_script("return [...document.querySelectorAll('.guide text')].map(t => t.textContent)"), ["x", "y", "z"])
        metres, pixels = self.run_script("""const v = kilotouch.view, bar = v.guide.querySelector('.length'), [n, unit] = bar.textContent.split(' ');
            const a = v.controls.target.clone(), right = new THREE.Vector3().setFromMatrixColumn(v.camera.matrixWorld, 0), length = n * {m: 1, mm: 1e-3}[unit];
            const b = a.clone().addScaledVector(right, length).project(v.camera), o = a.project(v.camera);
            return [bar.getBoundingClientRect().width, Math.abs(b.x - o.x) / 2 * v.container.clientWidth]""")
        self.assertAlmostEqual(metres, pixels, delta=0.03 * pixels + 1)

    def test_a_quantity_has_one_colour_everywhere(self):
        sys.path.insert(0, os.path.join(SOURCE, "scripts"))
        from report_parts.palette import PALETTE
        self.open()
        for name in ("normal", "tangential", "stick", "frictional_slide", "displacement"):
            self.assertEqual(self.run_script("return paletteOf(arguments[0])", name).split(), PALETTE[name], name)
        self.assertEqual(len({PALETTE[n][0] for n in ("normal", "tangential", "force", "limit", "stick", "frictional_slide", "slide", "body", "tool")}), 9)


class Dropped(Browser):
    def test_a_surface_with_a_hole_is_repaired_and_has_the_name_of_its_file(self):
        with open(os.path.join(SOURCE, "meshes", "organ.off"), encoding="utf-8") as file:
            lines = [line for line in file.read().split("\n") if not line.startswith("#")]
        nodes, triangles = (int(n) for n in lines[1].split()[:2])
        self.open()
        with tempfile.TemporaryDirectory() as folder:
            mesh = os.path.join(folder, "liver of Anna.off")
            with open(mesh, "w", encoding="utf-8") as file:
                file.write("\n".join([lines[0], f"{nodes} {triangles - 1} 0", *lines[2:2 + nodes + triangles - 1], ""]))
            self.browser.find_element("id", "file").send_keys(mesh)
            self.wait("document.querySelector('#findings button')")
        text = self.browser.find_element("id", "findings").text
        self.assertIn("liver of Anna.off", text)
        button = self.browser.find_element("css selector", "#findings button")
        self.assertEqual(button.text, "Repair and touch")
        button.click()
        self.wait("kilotouch.state.hello.title === 'liver of Anna.off (dropped)' || document.getElementById('message').className === 'bad'", PATIENCE)
        message = self.browser.find_element("id", "message").text
        self.assertNotIn("/tmp", message)
        self.assertEqual(self.run_script("return kilotouch.state.hello.title"), "liver of Anna.off (dropped)", message)

    def test_what_is_wrong_with_a_file_is_told_by_its_name(self):
        self.open()
        with tempfile.TemporaryDirectory() as folder:
            mesh = os.path.join(folder, "broken.off")
            with open(mesh, "w", encoding="utf-8") as file:
                file.write("OFF\n1 1 0\n0 0 zero\n")
            self.browser.find_element("id", "file").send_keys(mesh)
            self.wait("document.getElementById('findings').textContent.includes('zero')")
        text = self.browser.find_element("id", "findings").text
        self.assertTrue(text.startswith("broken.off"), text)
        self.assertNotIn("\\n", text)
        self.assertNotIn("/", text)


class Blind(Browser):
    options = ["--disable-gpu", "--disable-3d-apis"]

    def test_without_webgl_plot_numbers_and_settings_go_on(self):
        self.open()
        self.assertTrue(self.run_script("return document.getElementById('blind').checkVisibility()"))
        self.assertEqual([e for e in self.browser.get_log("browser") if e["level"] == "SEVERE" and "WebGL" not in e["message"]], [])
        self.wait("kilotouch.plot.count > 10")
        self.browser.find_element("id", "setting").send_keys("contact.mu=0.65\n")
        self.wait("kilotouch.state.status.settings['contact.mu'] === '0.65'")
        self.wait("document.getElementById('now').textContent.includes('normal')")
        before = self.run_script("return kilotouch.view.frame.target[2]")
        self.run_script("pointer.step(0, 1, 0)")  # an arrow key
        self.wait(f"Math.abs(kilotouch.view.frame.target[2] - ({before})) > 1e-4")


del Browser  # no tests of its own

if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[1:], verbosity=2)
