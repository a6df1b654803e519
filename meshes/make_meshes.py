#!/usr/bin/env python3
"""Makes every mesh in this folder: python3 meshes/make_meshes.py [folder]. Standard library only, no randomness:
the files come out byte for byte the same. Lengths in metres. meshes/README.md says what each is for."""
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(os.path.dirname(HERE), "scripts"))
from mesh_shapes import icosphere  # noqa: E402

FOLDER = sys.argv[1] if len(sys.argv) > 1 else HERE


def number(value):
    """At most 9 decimals (a nanometre) and no -0: small files that read back to the same doubles."""
    text = f"{value:.9f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def write_off(name, points, faces, comment):
    path = os.path.join(FOLDER, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", newline="\n") as out:
        out.write(f"OFF\n# {comment}. Metres. Made by meshes/make_meshes.py\n{len(points)} {len(faces)} 0\n")
        for p in points:
            out.write(" ".join(number(c) for c in p) + "\n")
        for f in faces:
            out.write(f"{len(f)} " + " ".join(map(str, f)) + "\n")


def write_text(name, content):
    path = os.path.join(FOLDER, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", newline="\n") as out:
        out.write(content)


class Builder:
    """Collects quads as two triangles each and joins corners at equal grid positions."""

    def __init__(self):
        self.points, self.faces, self.known = [], [], {}

    def vertex(self, key, position):
        if key not in self.known:
            self.known[key] = len(self.points)
            self.points.append(position)
        return self.known[key]

    def quad(self, a, b, c, d, flip_diagonal=False):
        if flip_diagonal:
            self.faces += [(a, b, d), (b, c, d)]
        else:
            self.faces += [(a, b, c), (a, c, d)]


def voxel_surface(cells, step, origin=(0.0, 0.0, 0.0)):
    """Boundary of a set of grid cells, each boundary square as two triangles, outward. Diagonals alternate, so that
    a flat side has no preferred direction."""
    cells = set(cells)
    b = Builder()
    # For each direction: the four corners of that side of the unit cube, counter-clockwise seen from outside.
    sides = {(1, 0, 0): [(1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)],
             (-1, 0, 0): [(0, 0, 0), (0, 0, 1), (0, 1, 1), (0, 1, 0)],
             (0, 1, 0): [(0, 1, 0), (0, 1, 1), (1, 1, 1), (1, 1, 0)],
             (0, -1, 0): [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)],
             (0, 0, 1): [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
             (0, 0, -1): [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)]}
    for cell in sorted(cells):
        for d, corners in sides.items():
            if tuple(c + e for c, e in zip(cell, d)) in cells:
                continue
            ids = []
            for corner in corners:
                key = tuple(c + e for c, e in zip(cell, corner))
                ids.append(b.vertex(key, tuple(o + k * s for o, k, s in zip(origin, key, step))))
            b.quad(*ids, flip_diagonal=sum(cell) % 2 == 1)
    return b.points, b.faces


def box(nx, ny, nz, size):
    cells = [(i, j, k) for i in range(nx) for j in range(ny) for k in range(nz)
             if i in (0, nx - 1) or j in (0, ny - 1) or k in (0, nz - 1)]
    inner = [(i, j, k) for i in range(1, nx - 1) for j in range(1, ny - 1) for k in range(1, nz - 1)]
    return voxel_surface(cells + inner, (size[0] / nx, size[1] / ny, size[2] / nz))


def graded_slab():
    """A slab of 100 x 60 x 30 mm below the plane z = 0, its middle below the origin. Grid lines every 2.5 mm around the
    middle line of the top, farther and farther apart away from it."""
    def lines(fine, *rest):  # from the middle outward
        half = [0.0025 * i for i in range(int(round(fine / 0.0025)) + 1)] + list(rest)
        return [-c for c in reversed(half[1:])] + half

    x = lines(0.02, 0.026, 0.036, 0.05)
    y = lines(0.0075, 0.0125, 0.02, 0.03)
    z = [-0.03, -0.02, -0.0125, -0.007, -0.003, 0.0]
    cells = [(i, j, k) for i in range(len(x) - 1) for j in range(len(y) - 1) for k in range(len(z) - 1)]
    points, faces = voxel_surface(cells, (1, 1, 1))
    return [(x[int(i)], y[int(j)], z[int(k)]) for i, j, k in points], faces


def refined(points, faces, wanted):
    """Halves edges, the longest first, until none is longer than wanted(middle, length): flat sides stay flat."""
    points, faces = list(points), [tuple(f) for f in faces]
    while True:
        sides = {}
        for i, f in enumerate(faces):
            for a, b in zip(f, f[1:] + f[:1]):
                sides.setdefault((min(a, b), max(a, b)), []).append(i)
        middle = {e: tuple((u + v) / 2 for u, v in zip(points[e[0]], points[e[1]])) for e in sides}
        length = {e: round(math.dist(points[e[0]], points[e[1]]), 9) for e in sides}  # equal ones are equal everywhere
        long = sorted((-length[e], e) for e in sides if length[e] > wanted(middle[e], length[e]))
        if not long:
            return points, faces
        split = set()
        for _, (a, b) in long:
            beside = sides[a, b]
            if split & set(beside):
                continue  # in the next pass
            split |= set(beside)
            points.append(middle[a, b])
            for i in beside:
                f = faces[i]
                faces[i] = tuple(len(points) - 1 if v == a else v for v in f)
                faces.append(tuple(len(points) - 1 if v == b else v for v in f))


def graded_pad():
    """The pad, with edges of 1.5 mm within 4.5 mm of the middle of its top, longer by half of the distance beyond."""
    def wanted(p, length):
        away = math.dist(p, (0.025, 0.025, 0.02)) - length / 2 - 0.0045
        return 0.0015 + 0.5 * max(0.0, away)

    return refined(*box(5, 5, 2, (0.05, 0.05, 0.02)), wanted)


def organ_shape(u):
    """A smooth lobe with a hollow on one side, like a kidney: 0.12 x 0.08 x 0.05 m."""
    x, y, z = u
    hollow = math.exp(-((x / 0.45) ** 2 + (z / 0.9) ** 2)) if y < 0 else 0.0
    fade = min(1.0, max(0.0, -y)) ** 2
    r = 1.0 - 0.45 * hollow * fade + 0.06 * x * x * y + 0.05 * x
    return (0.06 * x * r, 0.04 * y * r, 0.025 * z * (1.0 - 0.25 * hollow * fade + 0.05 * x))


def torus(n, m, big, small):
    b = Builder()
    for i in range(n):
        for j in range(m):
            ids = []
            for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1)):
                a, c = (i + di) % n, (j + dj) % m
                u, v = 2 * math.pi * a / n, 2 * math.pi * c / m
                r = big + small * math.cos(v)
                ids.append(b.vertex((a, c), (r * math.cos(u), r * math.sin(u), small * math.sin(v))))
            b.quad(*ids, flip_diagonal=(i + j) % 2 == 1)
    return b.points, b.faces


def tube(n, m, length, inner, outer):
    """A hollow tube along x: n rings of m corners, inside and outside; both ends are flat rings."""
    b = Builder()

    def corner(side, i, j):
        a, r = 2 * math.pi * (j % m) / m, (inner, outer)[side]
        return b.vertex((side, i, j % m), (length * i / n, r * math.cos(a), r * math.sin(a)))

    for i in range(n):
        for j in range(m):
            square = [corner(1, i, j), corner(1, i, j + 1), corner(1, i + 1, j + 1), corner(1, i + 1, j)]
            b.quad(*square, flip_diagonal=(i + j) % 2 == 1)
            square = [corner(0, i, j), corner(0, i, j + 1), corner(0, i + 1, j + 1), corner(0, i + 1, j)]
            b.quad(*square[::-1], flip_diagonal=(i + j) % 2 == 1)
    for j in range(m):
        b.quad(corner(0, 0, j + 1), corner(1, 0, j + 1), corner(1, 0, j), corner(0, 0, j))
        b.quad(corner(0, n, j), corner(1, n, j), corner(1, n, j + 1), corner(0, n, j + 1))
    return b.points, b.faces


def pierced_plate():
    """A plate with five square holes: genus 5."""
    holes = {(2, 2), (2, 6), (6, 2), (6, 6), (4, 4)}
    cells = [(i, j, k) for i in range(9) for j in range(9) for k in range(2) if (i, j) not in holes]
    return voxel_surface(cells, (0.01, 0.01, 0.01))


def cube(size=0.02, origin=(0.0, 0.0, 0.0)):
    return voxel_surface([(0, 0, 0)], (size, size, size), origin)


def joined(*meshes):
    points, faces = [], []
    for p, f in meshes:
        faces += [tuple(i + len(points) for i in face) for face in f]
        points += p
    return points, faces


def good_meshes():
    write_off("slab_coarse.off", *box(20, 20, 6, (0.1, 0.1, 0.03)), "slab 0.1 x 0.1 x 0.03, 5 mm triangles")
    write_off("slab_fine.off", *box(40, 40, 12, (0.1, 0.1, 0.03)), "slab 0.1 x 0.1 x 0.03, 2.5 mm triangles")
    write_off("slab_graded.off", *graded_slab(), "slab 0.1 x 0.06 x 0.03, finest along the middle of its top")
    write_off("pad.off", *box(5, 5, 2, (0.05, 0.05, 0.02)), "pad 0.05 x 0.05 x 0.02, 10 mm triangles")
    write_off("pad_graded.off", *graded_pad(), "pad 0.05 x 0.05 x 0.02, finest at the middle of its top")
    directions, faces = icosphere(3)
    write_off("sphere.off", [tuple(0.03 * c for c in d) for d in directions], faces, "icosphere, radius 0.03")
    write_off("organ.off", list(map(organ_shape, directions)), faces, "smooth kidney-like lobe")
    write_off("sheet.off", *box(20, 20, 1, (0.1, 0.1, 0.002)), "closed thin plate 0.1 x 0.1 x 0.002")
    write_off("torus.off", *torus(32, 16, 0.04, 0.015), "torus, radii 0.04 and 0.015")
    write_off("genus5.off", *pierced_plate(), "plate with five square holes")


def gallery_meshes():
    write_off("gallery/tube.off", *tube(12, 16, 0.06, 0.008, 0.012), "tube along x, 60 mm, radii 8 and 12 mm")
    write_off("gallery/finger.off", *box(16, 3, 3, (0.08, 0.015, 0.015)), "bar 80 x 15 x 15 mm, 5 mm triangles")


def broken_meshes():
    points, faces = cube()
    write_off("broken/open.off", points, faces[:-1], "cube without one triangle")
    write_off("broken/flipped_face.off", points, faces[:3] + [faces[3][::-1]] + faces[4:], "cube, face 3 turned inward")
    write_off("broken/inside_out.off", points, [f[::-1] for f in faces], "cube, all faces turned inward")
    apex = points + [(0.04, 0.01, -0.02)]  # outside: the fin crosses nothing
    edge = next((f[0], f[1]) for f in faces)
    write_off("broken/nonmanifold_edge.off", apex, faces + [(edge[0], edge[1], 8)], "cube with a fin: three faces on an edge")
    bow_points, bow_faces = joined(cube(), cube(origin=(0.02, 0.02, 0.02)))
    first = bow_points.index((0.02, 0.02, 0.02))
    second = bow_points.index((0.02, 0.02, 0.02), 8)
    bow_faces = [tuple(first if i == second else i - (i > second) for i in f) for f in bow_faces]
    del bow_points[second]
    write_off("broken/nonmanifold_vertex.off", bow_points, bow_faces, "two cubes that share one corner (bow tie)")
    write_off("broken/self_intersecting.off", *joined(cube(), cube(origin=(0.013, 0.011, 0.007))), "two cubes that overlap")
    write_off("broken/duplicate_degenerate.off", points + [(0.05, 0.05, 0.05)],
              faces + [faces[0], (faces[1][1], faces[1][2], faces[1][0]), (0, 0, 1), (2, 3, 2)],
              "cube, two faces twice, two faces without area, one vertex unused")
    good = "OFF\n4 4 0\n0 0 0\n0.02 0 0\n0 0.02 0\n0 0 0.02\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
    write_text("broken/nan.off", good.replace("0 0.02 0", "0 nan 0"))
    write_text("broken/truncated.off", good[:good.index("3 1 2 3")])
    write_text("broken/index_out_of_range.off", good.replace("3 1 2 3", "3 1 2 7"))
    write_text("broken/wrong_count.off", good.replace("4 4 0", "2000000000 4 0"))
    write_text("broken/not_a_number.obj", "v 0 0 0\nv 1 O 0\nv 0 1 0\nf 1 2 3\n")
    write_text("broken/empty.off", "")


def block_cells(nx, ny, nz, h, origin=(0.0, 0.0, 0.0), first=1):
    """Nodes and tetrahedra of a regular block of cubes, six tetrahedra each; nodes are counted from `first`."""
    index = lambda i, k, l: first + (i * (ny + 1) + k) * (nz + 1) + l
    nodes = [(origin[0] + i * h, origin[1] + k * h, origin[2] + l * h)
             for i in range(nx + 1) for k in range(ny + 1) for l in range(nz + 1)]
    walks = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]  # Kuhn: one tetrahedron a walk
    cells = []
    for i in range(nx):
        for k in range(ny):
            for l in range(nz):
                for walk in walks:
                    at = [i, k, l]
                    cell = [index(*at)]
                    for axis in walk:
                        at[axis] += 1
                        cell.append(index(*at))
                    if walk in ((0, 2, 1), (1, 0, 2), (2, 1, 0)):  # an odd walk is mirrored: keep volumes positive
                        cell[2], cell[3] = cell[3], cell[2]
                    cells.append(cell)
    return nodes, cells


def write_msh(name, nodes, cells):
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(nodes))]
    lines += [f"{i + 1} {number(x)} {number(y)} {number(z)}" for i, (x, y, z) in enumerate(nodes)]
    lines += ["$EndNodes", "$Elements", str(len(cells))]
    lines += [f"{i + 1} 4 2 1 1 {' '.join(map(str, c))}" for i, c in enumerate(cells)]
    lines += ["$EndElements", ""]
    write_text(name, "\n".join(lines))


def tetrahedra():
    # The paper's kind of body: 80 x 50 x 20 mm.
    write_msh("block.msh", *block_cells(16, 10, 4, 0.005))
    # Two bodies in one mesh, 0.3 mm apart: 30 x 30 x 10 mm over 40 x 40 x 15 mm.
    below = block_cells(8, 8, 3, 0.005)
    above = block_cells(6, 6, 2, 0.005, (0.0055, 0.0045, 0.0153), first=1 + len(below[0]))
    write_msh("two_blocks.msh", below[0] + above[0], below[1] + above[1])


if __name__ == "__main__":
    good_meshes()
    gallery_meshes()
    tetrahedra()
    broken_meshes()
