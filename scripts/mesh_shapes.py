"""Small closed surfaces, and the kinds of file that they are written as. Standard library only."""
import math
import struct


# ---- shapes: points and faces, closed, outward

def icosphere(levels):
    t = (1 + math.sqrt(5)) / 2
    points = [(-1, t, 0), (1, t, 0), (-1, -t, 0), (1, -t, 0), (0, -1, t), (0, 1, t), (0, -1, -t), (0, 1, -t), (t, 0, -1), (t, 0, 1), (-t, 0, -1), (-t, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    unit = lambda p: tuple(c / math.sqrt(sum(d * d for d in p)) for c in p)
    points = [unit(p) for p in points]
    for _ in range(levels):
        middle, finer = {}, []

        def between(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle:
                middle[key] = len(points)
                points.append(unit(tuple((x + y) / 2 for x, y in zip(points[a], points[b]))))
            return middle[key]

        for a, b, c in faces:
            ab, bc, ca = between(a, b), between(b, c), between(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return points, faces


def torus(around=24, tube=12):
    points = [((1 + 0.4 * math.cos(2 * math.pi * j / tube)) * math.cos(2 * math.pi * i / around),
               (1 + 0.4 * math.cos(2 * math.pi * j / tube)) * math.sin(2 * math.pi * i / around),
               0.4 * math.sin(2 * math.pi * j / tube)) for i in range(around) for j in range(tube)]
    node = lambda i, j: (i % around) * tube + j % tube
    quads = [(node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)) for i in range(around) for j in range(tube)]
    return points, [f for a, b, c, d in quads for f in ((a, b, c), (a, c, d))]


def box(nx, ny, nz):
    nodes, faces = {}, []

    def quad(*corners):
        i = [nodes.setdefault(p, len(nodes)) for p in corners]
        faces.extend([(i[0], i[1], i[2]), (i[0], i[2], i[3])])

    for x in range(nx):
        for y in range(ny):
            quad((x, y, nz), (x + 1, y, nz), (x + 1, y + 1, nz), (x, y + 1, nz))
            quad((x, y, 0), (x, y + 1, 0), (x + 1, y + 1, 0), (x + 1, y, 0))
    for z in range(nz):
        for x in range(nx):
            quad((x, 0, z), (x + 1, 0, z), (x + 1, 0, z + 1), (x, 0, z + 1))
            quad((x, ny, z), (x, ny, z + 1), (x + 1, ny, z + 1), (x + 1, ny, z))
        for y in range(ny):
            quad((0, y, z), (0, y, z + 1), (0, y + 1, z + 1), (0, y + 1, z))
            quad((nx, y, z), (nx, y + 1, z), (nx, y + 1, z + 1), (nx, y, z + 1))
    return [tuple(map(float, p)) for p in nodes], faces


def organ(levels=2):
    points, faces = icosphere(levels)
    bump = lambda x, y, z: 1 + 0.18 * math.sin(2 * x + 1) * math.cos(3 * y) + 0.1 * math.sin(4 * z)
    return [(1.3 * x * bump(x, y, z), y * bump(x, y, z), 0.8 * z * bump(x, y, z)) for x, y, z in points], faces


SHAPES = {"sphere": lambda: icosphere(2), "coarse": lambda: icosphere(1), "torus": torus, "box": lambda: box(5, 4, 3), "organ": organ}


# ---- files

def write_off(points, faces):
    return ("OFF\n%d %d 0\n" % (len(points), len(faces)) + "".join("%r %r %r\n" % p for p in points) + "".join("3 %d %d %d\n" % f for f in faces)).encode()


def write_obj(points, faces):
    return ("".join("v %r %r %r\n" % p for p in points) + "".join("f %d %d %d\n" % tuple(i + 1 for i in f) for f in faces)).encode()


def write_ply(points, faces):
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    return (head + "".join("%r %r %r\n" % p for p in points) + "".join("3 %d %d %d\n" % f for f in faces)).encode()


def write_ply_binary(points, faces):
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    return head.encode() + b"".join(struct.pack("<3d", *p) for p in points) + b"".join(struct.pack("<B3i", 3, *f) for f in faces)


def write_stl(points, faces):
    corner = lambda p: "vertex %.9g %.9g %.9g\n" % p
    return ("solid s\n" + "".join("facet normal 0 0 0\nouter loop\n" + "".join(corner(points[i]) for i in f) + "endloop\nendfacet\n" for f in faces) + "endsolid s\n").encode()


def write_stl_binary(points, faces):
    return b"\0" * 80 + struct.pack("<I", len(faces)) + b"".join(struct.pack("<12fH", 0, 0, 0, *points[f[0]], *points[f[1]], *points[f[2]], 0) for f in faces)


FILES = {"off": ("off", write_off), "obj": ("obj", write_obj), "ply": ("ply", write_ply), "plyb": ("ply", write_ply_binary),
         "stl": ("stl", write_stl), "stlb": ("stl", write_stl_binary)}
