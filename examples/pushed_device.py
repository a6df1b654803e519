"""A device that Python drives: poses in, forces out, each made safe by the engine. Here a stylus that is lowered into the
body, and unplugged at the end. PYTHONPATH has the package; run in the project's folder."""
import time

import numpy as np

import kilotouch as kt

scene = kt.Scene(settings={
    "object.mesh": "meshes/block.msh", "duration": 60,
    "tool.path.device.name": "pushed", "tool.path.device.origin": [0, 0, 0], "tool.path.device.max_force": 0.1})
device = kt.PushedDevice()


def place(t):
    """Stands for a driver that reads its device [m]: 8 mm down in a second and a half."""
    return np.array([0.03, 0.026, 0.03 - 0.008 * min(1, t / 1.5)])


device.push(place(0))
session = kt.Session(scene)
session.start(pushed=device)
while session.is_running and session.progress == 0:  # the body is set up
    device.push(place(0))
    time.sleep(1e-3)
most, begun = 0, time.monotonic()
while (t := time.monotonic() - begun) < 2 or (most == 0 and t < 60):  # a busy machine shuts the gate now and then
    device.push(place(t))
    force, torque = device.order  # what is to be written to the device now
    most = max(most, np.linalg.norm(force))
    time.sleep(1e-3)
time.sleep(0.06)  # unplugged: no pose comes any more
at_the_end = np.linalg.norm(device.order[0])
trace = session.stop()
print(f"at most {most:.4f} N of {np.linalg.norm(trace.force, axis=1).max():.4f} N; at the end {at_the_end:.4f} N")
