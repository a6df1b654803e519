"""What the tests of the Python package share: PYTHONPATH has the package, KILOTOUCH names the program, KT_LIBRARY the C library."""
import os
import subprocess
import sys

import numpy as np

import kilotouch as kt

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.abspath(os.environ.get("KILOTOUCH", os.path.join(ROOT, "build", "release", "kilotouch")))
LIBRARY = os.environ.get("KT_LIBRARY", os.path.join(ROOT, "build", "release", "libkilotouch.so"))
BLOCK = os.path.join(ROOT, "meshes", "block.msh")
ORGAN = os.path.join(ROOT, "scenes", "organ_springs.json")
QUICK = {"object.mesh": BLOCK, "local.reducer": "wall", "collision.backend": "brute_force", "duration": 0.3,
         "tool.path.press_drag.press_time": 0.1, "tool.path.press_drag.depth": 0.003}
PATIENCE = 600  # [s]: as tests/apps/patience.py
TOP = np.array([0.03, 0.026, 0.03])


def press(depth, ticks, top=TOP):
    """A straight way down: (ticks + 1, 3)."""
    way = np.repeat(top[None], ticks + 1, 0)
    way[:, 2] -= np.linspace(0, depth, ticks + 1)
    return way


def script(text, **kwargs):
    return subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **kwargs)


class Linear(kt.Model):
    """Linear elasticity on tetrahedra with lumped mass, from its definition: K = V B' C B, D = 5 M + 2e-3 K."""

    YOUNG, POISSON, DENSITY = 1e4, 0.3, 1000.0

    def __init__(self, mesh):
        import scipy.sparse
        x, tets = mesh.x, mesh.tetrahedra
        lam = self.YOUNG * self.POISSON / ((1 + self.POISSON) * (1 - 2 * self.POISSON))
        mu = self.YOUNG / (2 * (1 + self.POISSON))
        edges = x[tets[:, 1:]] - x[tets[:, :1]]  # (n, 3, 3), a row an edge
        volume = np.linalg.det(edges) / 6
        mass = np.bincount(tets.ravel(), np.repeat(self.DENSITY * volume / 4, 4), len(x))
        inverse = np.linalg.inv(edges)
        g = np.concatenate([-inverse.sum(2)[:, :, None], inverse], 2)  # gradients of the shape functions (n, 3, 4)
        k = np.einsum("n,nia,njb->naibj", volume * lam, g, g) + np.einsum("n,nja,nib->naibj", volume * mu, g, g)
        k += np.einsum("n,nla,nlb,ij->naibj", volume * mu, g, g, np.eye(3))
        dofs = (3 * tets[:, :, None] + np.arange(3)).reshape(-1, 12)
        rows, columns, values = np.repeat(dofs, 12, 1).ravel(), np.tile(dofs, 12).ravel(), k.ravel()
        low = x[:, 2] <= x[:, 2].min() + 0.05 * np.ptp(x[:, 2])
        super().__init__(mesh, mass, np.flatnonzero(low))
        self.k = scipy.sparse.csc_matrix((values, (rows, columns)), shape=self.mass.shape)
        self.d = 5.0 * self.mass + 2e-3 * self.k

    def force(self, x, v):
        return -(self.k @ (x - self.mesh.x).ravel()) - self.d @ v.ravel()

    def tangent(self, x, v, definite):
        return -self.k, -self.d
