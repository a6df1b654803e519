"""The height of a surface at many places, and a press at each."""


def height(body, xy):
    """Height of the surface over each point of the xy plane, (n,) [m], nan beside the body. Seen from above, the first that a tool meets.

    `body` is a Touch, deformed as its `positions` are, or a Mesh. `xy` is (n, 2) [m], or one (2,).
    """
    import numpy
    from . import InputError, Mesh
    mesh = body if isinstance(body, Mesh) else body.mesh
    x = mesh.x if isinstance(body, Mesh) else body.positions
    at = numpy.asarray(xy, float)
    if at.shape[-1:] != (2,) or at.ndim > 2:
        raise InputError(f"xy: shape {at.shape}, must be (n, 2) or (2,) [m]")
    corners = x[mesh.triangles]                              # (triangle, corner, axis)
    low, high = corners[..., :2].min(1), corners[..., :2].max(1)
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    out = numpy.full(len(at.reshape(-1, 2)), numpy.nan)
    for i, p in enumerate(at.reshape(-1, 2)):
        near = ((low <= p) & (p <= high)).all(1) & (area != 0)
        d = p - a[near, :2]
        u, v = (b - a)[near], (c - a)[near]
        s = (d[:, 0] * v[:, 1] - d[:, 1] * v[:, 0]) / area[near]
        t = (u[:, 0] * d[:, 1] - u[:, 1] * d[:, 0]) / area[near]
        inside = (s >= -1e-9) & (t >= -1e-9) & (s + t <= 1 + 1e-9)
        if inside.any():
            out[i] = (a[near, 2] + s * u[:, 2] + t * v[:, 2])[inside].max()
    return out if at.ndim == 2 else out[0]


def press(scene, xy, depth, speed=0.025, rest=0.01, jobs=None, mesh=None, model=None):
    """Presses straight down at each point of xy, each time on the body at rest, and gives the force after a rest.

    A tool touches the surface at xy, goes down by depth [m] at speed [m/s], and waits for rest [s]. Returns a dict of the arrays `height`
    [m] of the surface, `force` (n, 3) [N], `f_n` [N], `flags`. A point beside the body has nan. Results do not depend on `jobs`.

    `xy` is (n, 2) [m]. The tool's turn is that of the scene's frame. `jobs` presses run at a time. All share the body and its first
    local model.
    """
    import concurrent.futures
    import os
    import threading
    import numpy
    from . import InputError, Touch
    at = numpy.asarray(xy, float)
    if at.ndim != 2 or at.shape[1] != 2:
        raise InputError(f"xy: shape {at.shape}, must be (n, 2) [m]")
    for name, value in (("depth", depth), ("speed", speed)):
        if not 0 < value < float("inf"):
            raise InputError(f"{name}: {value}, must be above 0")
    if not 0 <= rest < float("inf"):
        raise InputError(f"rest: {rest}, must be 0 s or more")
    radius = scene["tool.radius"] if scene["tool.shape"] == "sphere" else 0.0 if scene["tool.shape"] == "point" else None
    if radius is None:
        raise InputError(f"tool.shape: {scene['tool.shape']}; press() takes a sphere or a point")
    first = Touch(scene, mesh=mesh, model=model)
    if first.num_tools != 1:
        raise InputError(f"press() takes a scene with one tool, this one has {first.num_tools}")
    heights = height(first.mesh, at)
    clear = 0.05 * depth                                     # above the surface at the start
    ticks = max(1, round((depth + clear) / speed / first.h))
    force, f_n, flags = numpy.full((len(at), 3), numpy.nan), numpy.full(len(at), numpy.nan), numpy.zeros(len(at), numpy.uint32)
    own = threading.local()

    def in_own_touch(i):
        if not hasattr(own, "touch"):
            own.touch = Touch(scene, body_of=first)
        one(own.touch, i)

    def one(touch, i):
        top = heights[i] + radius + clear
        touch.reset(start)
        touch.place([*at[i], top])
        for k in range(ticks + round(rest / touch.h) + 1):
            frame = touch.tick([*at[i], top - min(1, k / ticks) * (depth + clear)])
        force[i], f_n[i], flags[i] = frame.force, frame.f_n, int(frame.flags)

    start = None
    todo = [i for i in range(len(at)) if not numpy.isnan(heights[i])]
    if todo:
        first.tick([*at[todo[0]], heights[todo[0]] + radius + clear])
        start = first.state  # with the first local model, for all
        one(first, todo[0])
    with concurrent.futures.ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
        for _ in pool.map(in_own_touch, todo[1:]):
            pass
    return {"height": heights, "force": force, "f_n": f_n, "flags": flags}
