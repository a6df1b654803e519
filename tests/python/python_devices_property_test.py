#!/usr/bin/python3
"""Devices that Python drives: what they are given is safe."""
import math
import time
import unittest

import numpy as np

import kilotouch as kt
from support import PATIENCE, QUICK, TOP


class Devices(unittest.TestCase):
    HELD = {**QUICK, "duration": 60, "tool.path.device.name": "pushed", "tool.path.device.max_force": 0.1,
            "tool.path.device.deadman": 1, "tool.path.device.origin": [0, 0, 0]}

    def test_tick_device_is_made_safe(self):
        touch = kt.Touch(kt.Scene(settings={k: v for k, v in self.HELD.items() if "press_drag" not in k}))
        most, before, zero_after = 0, np.zeros(3), None
        x = TOP.copy()
        touch.place(x)
        for i in range(1500):
            if i < 1200:
                x[2] = 0.03 - 0.008 * min(1, i / 800)
            age = 0 if i < 1200 else 1e-3 * (i - 1199)
            force = touch.tick_device(kt.DeviceReading(x, age=age, buttons=1)).force
            most = max(most, np.linalg.norm(force))
            if i < 1200:
                self.assertLessEqual(np.linalg.norm(force - before), 0.2 + 1e-12, i)  # 200 N/s
            if i >= 1200 and zero_after is None and not force.any():
                zero_after = age
            before = force
        self.assertAlmostEqual(most, 0.1, delta=1e-9)
        self.assertLessEqual(zero_after, 0.0201)
        told = " ".join(touch.warnings)
        self.assertIn("gate was shut or not fully open", told)
        self.assertIn("pose was too old", told)
        self.assertIn("the force was cut to the device's limit in", told)
        with self.assertRaisesRegex(kt.InputError, 'did you mean "fault"'):
            kt.DeviceReading(x, health="fualt")

    def test_a_gate_that_never_opens_is_told(self):
        touch = kt.Touch(kt.Scene(settings={k: v for k, v in self.HELD.items() if "press_drag" not in k}))
        x = TOP.copy()
        touch.place(x)
        for i in range(400):
            x[2] = 0.03 - 0.004 * min(1, i / 300)
            touch.tick_device(kt.DeviceReading(x, age=0.006, buttons=1))  # 5 ms are the most
        self.assertTrue(any("gate never opened fully" in line and "older than 5 ms" in line for line in touch.warnings), touch.warnings)

    def test_pushed_device_gets_what_is_safe_and_nothing_when_it_is_silent(self):
        device = kt.PushedDevice()
        session = kt.Session(kt.Scene(settings={k: v for k, v in self.HELD.items() if "press_drag" not in k}))
        device.push(TOP, buttons=1)
        session.start(pushed=device)
        while session.is_running and session.progress == 0:
            device.push(TOP, buttons=1)
            time.sleep(1e-3)
        most, felt = 0, 0
        begun = time.monotonic()
        while (t := time.monotonic() - begun) < 1.6 or (felt <= 0.02 and t < PATIENCE):  # on a busy machine the gate shuts now and then
            x = TOP - [0, 0, 0.008 * min(1, t / 1.2)]
            device.push(x, buttons=1)
            force, torque = device.order
            most = max(most, np.linalg.norm(force))
            felt = max(felt, force[2])
            self.assertTrue(np.isfinite([*force, *torque]).all())
            time.sleep(0.5e-3)
        time.sleep(0.06)  # no pose, for longer than 20 ms whatever the machine does
        force, _ = device.order
        self.assertEqual(np.linalg.norm(force), 0)
        trace = session.stop()
        self.assertGreater(felt, 0.02)
        self.assertLessEqual(most, 0.1 + 1e-12)
        self.assertEqual(np.linalg.norm(device.order[0]), 0)  # the tick has stopped
        self.assertGreater(len(trace), 1000)
        self.assertTrue((trace.flags & kt.Flag.STALE_POSE).any())

    def test_a_device_is_of_one_session(self):
        settings = {k: v for k, v in self.HELD.items() if "press_drag" not in k}
        device = kt.PushedDevice()
        device.push(TOP, buttons=1)
        first, second = (kt.Session(kt.Scene(settings=settings)) for _ in range(2))
        first.start(pushed=device)
        with self.assertRaisesRegex(kt.InputError, "another session"):
            second.start(pushed=device)
        first.stop()
        device.push(TOP, buttons=1)
        second.start(pushed=device)
        second.stop()
        with self.assertRaisesRegex(kt.InputError, "is not pushed"):
            kt.Session(kt.Scene(settings=QUICK)).run(pushed=device)

    def test_wrong_readings_are_told(self):
        device = kt.PushedDevice()
        for pose, words in (([*TOP, 5, 0, 0, 0], "length 5"), ([1e30, 0, 0], "beyond"), (["1", "2", "3"], "numbers are needed")):
            with self.assertRaisesRegex(kt.InputError, words):
                device.push(pose)
            with self.assertRaisesRegex(kt.InputError, words):
                kt.DeviceReading(pose)
        with self.assertRaisesRegex(kt.InputError, "age: -5"):
            kt.DeviceReading(TOP, age=-5)
        with self.assertRaisesRegex(kt.InputError, "v: 3 numbers"):
            device.push(TOP, v=[1, 2])

    def test_pushed_device_without_poses_is_told(self):
        settings = {k: v for k, v in self.HELD.items() if "press_drag" not in k}
        with self.assertRaisesRegex(kt.InputError, "nobody pushes"):
            kt.Session(kt.Scene(settings=settings)).run()
        with self.assertRaisesRegex(kt.InputError, "no pose for 2 s"):
            kt.Session(kt.Scene(settings=settings)).run(pushed=kt.PushedDevice())
        device = kt.PushedDevice()
        with self.assertRaisesRegex(kt.InputError, "not finite; nothing was taken"):
            device.push([0, math.nan, 0])


if __name__ == "__main__":
    unittest.main()
