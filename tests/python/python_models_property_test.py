#!/usr/bin/python3
"""Physics written in Python, against the engine's own."""
import gc
import time
import unittest

import numpy as np

import kilotouch as kt
from support import BLOCK, Linear, QUICK, TOP, press


class Models(unittest.TestCase):
    SCENE = {**QUICK, "object.model.type": "fem", "object.model.material": "linear", "object.model.young": Linear.YOUNG,
             "object.model.poisson": Linear.POISSON, "object.model.damping.mass": 5, "object.model.damping.stiffness": 2e-3,
             "object.model.damping.law": "rayleigh", "global.tolerance": 1e-12, "local.refine": "off"}

    def setUp(self):
        try:
            import scipy.sparse  # noqa: F401
        except ImportError:
            self.skipTest("no scipy")

    def test_python_physics_gives_the_forces_of_the_same_in_c(self):
        mesh = kt.load_mesh(BLOCK)
        path = press(0.008, 200)
        theirs = kt.Session(kt.Scene(settings=self.SCENE)).run(path)
        ours = kt.Session(kt.Scene(settings={**QUICK, "global.tolerance": 1e-12}), model=Linear(mesh)).run(path)
        self.assertGreater(theirs.f_n[-1], 0.05)
        np.testing.assert_allclose(ours.force, theirs.force, atol=1e-9 * theirs.f_n.max())

    def test_tangent_by_differences_gives_the_same_forces(self):
        class Slow(Linear):
            tangent = None

        mesh = kt.load_mesh(BLOCK)
        path = press(0.006, 100)
        with_tangent, without = (kt.Session(kt.Scene(settings=QUICK), model=m(mesh)).run(path) for m in (Linear, Slow))
        np.testing.assert_allclose(without.force, with_tangent.force, atol=1e-6 * with_tangent.f_n.max())

    def test_check_tells_a_wrong_tangent(self):
        mesh = kt.load_mesh(BLOCK)
        passed, text = kt.check_model(Linear(mesh))
        self.assertTrue(passed, text)

        class Wrong(Linear):
            def tangent(self, x, v, definite):
                return -1.01 * self.k, -self.d

        passed, text = kt.check_model(Wrong(mesh))
        self.assertFalse(passed)
        self.assertIn("WRONG", text)

    def test_what_a_model_raises_ends_the_run_with_its_words(self):
        class Breaks(Linear):
            calls = 0

            def force(self, x, v):
                Breaks.calls += 1
                if Breaks.calls > 20:
                    raise ZeroDivisionError("the foam has burnt")
                return super().force(x, v)

        with self.assertRaisesRegex(kt.RunError, "model.force: ZeroDivisionError: the foam has burnt"):
            kt.Session(kt.Scene(settings=QUICK), model=Breaks(kt.load_mesh(BLOCK))).run()
        Breaks.calls = 0
        touch = kt.Touch(kt.Scene(settings=QUICK), model=Breaks(kt.load_mesh(BLOCK)))
        with self.assertRaisesRegex(kt.RunError, "the foam has burnt"):
            for x in press(0.008, 3000):
                touch.tick(x)

    def test_the_collector_may_come_in_the_middle_of_the_physics(self):
        class Forgotten(Linear):
            def force(self, x, v):
                gc.collect()
                return super().force(x, v)

        mesh = kt.load_mesh(BLOCK)
        for make in (kt.Session, kt.Touch):
            model = Forgotten(mesh)
            held = make(kt.Scene(settings={**QUICK, "duration": 0.2}), model=model)
            model.holds = [model, held]  # a cycle
            if make is kt.Touch:
                held.place(TOP)
            held.start()
            del held, model
            time.sleep(0.3)
            gc.collect()

    def test_a_model_does_not_wait_for_itself(self):
        class Impatient(Linear):
            def force(self, x, v):
                self.session.stop()

        model = Impatient(kt.load_mesh(BLOCK))
        model.session = kt.Session(kt.Scene(settings=QUICK), model=Linear(model.mesh))
        with self.assertRaisesRegex(kt.RunError, "model's own functions"):
            kt.Session(kt.Scene(settings=QUICK), model=model).run()

    def test_settings_that_do_nothing_are_told(self):
        trace = kt.Session(kt.Scene(settings={**QUICK, "object.model.young": 5e5}), model=Linear(kt.load_mesh(BLOCK))).run()
        self.assertIn("a model of one's own", " ".join(trace.warnings))

    def test_what_is_no_model_is_told(self):
        mesh = kt.load_mesh(BLOCK)
        scene = kt.Scene(settings=QUICK)
        n = len(mesh.x)

        class Short(Linear):
            def force(self, x, v):
                return np.zeros(3)

        import scipy.sparse
        torn = scipy.sparse.identity(3 * n, format="csc")
        torn.indices[5] = 10 * n
        for model, words in ((kt.Model(mesh, np.ones(n - 1)), "mass: .* must be"), (kt.Model(mesh, np.ones(n), [n]), "fixed: node"),
                             (object(), "model: has no mesh"), (kt.Model(mesh, np.ones(n), np.arange(n)), "all nodes are clamped"),
                             (kt.Model(mesh, np.zeros(n)), "mass: 0"), (kt.Model(mesh, np.full(n, np.nan)), "mass: a number"),
                             (kt.Model(mesh, torn), "out of range")):
            with self.assertRaisesRegex(kt.InputError, words):
                kt.Touch(scene, model=model)
        self.assertEqual(kt.Model(mesh, np.ones(n), mesh.x[:, 2] < 1e-6).fixed, list(np.flatnonzero(mesh.x[:, 2] < 1e-6)))
        for fixed in ([0.5, 1.5], [[0, 1]], np.ones(n - 1, bool)):
            with self.assertRaisesRegex(kt.InputError, "fixed"):
                kt.Model(mesh, np.ones(n), fixed)
        class Turned(Linear):
            def force(self, x, v):
                return np.zeros((3, len(x)))

        for wrong in (Short, Turned):
            with self.assertRaisesRegex(kt.RunError, f"must give {3 * n} numbers"):
                kt.Session(scene, model=wrong(mesh)).run()
        with self.assertRaisesRegex(kt.InputError, "give one"):
            kt.Touch(scene, mesh=mesh, model=Linear(mesh))


if __name__ == "__main__":
    unittest.main()
