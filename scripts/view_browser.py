"""A kilotouch view and a browser without a window, for scripts."""
import contextlib
import os
import re
import subprocess

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROGRAM = os.path.join(ROOT, "build", "release", "kilotouch")


@contextlib.contextmanager
def serve(program, what, *options):
    """The address of the page, and the process."""
    process = subprocess.Popen([program, "view", what, "--port", "0", *options], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        for line in process.stdout:
            if found := re.search(r"open (http://\S+)", line):
                yield found.group(1), process
                return
        raise SystemExit(f"{what}: the program ended")
    finally:
        process.terminate()
        process.wait(60)


@contextlib.contextmanager
def browser(width, height):
    """Chromium; it draws by software where there is no graphics processor."""
    from selenium import webdriver  # here: who only serves needs no browser
    from selenium.webdriver.chrome.service import Service
    options = webdriver.chrome.options.Options()
    for option in ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage",
                   f"--window-size={width},{height}"]:
        options.add_argument(option)
    it = webdriver.Chrome(options=options, service=Service("/usr/bin/chromedriver"))
    it.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
    try:
        yield it
    finally:
        it.quit()
