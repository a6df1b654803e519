"""Touch on deformable bodies at a kilohertz.

    import kilotouch as kt

    scene = kt.Scene("scenes/organ_drag.json", {"contact.mu": 0.8})
    trace = kt.Session(scene).run()                 # as `kilotouch run`
    trace.force                                     # (n, 3) [N], a row a tick

    touch = kt.Touch(scene)                         # your loop
    frame = touch.tick([0.02, 0.03, 0.04])          # the tool is there now [m]
    frame.force, frame.mode

SI units, world frame. Wrong input raises InputError of one line with quantity, place, value and allowed range.
docs/python.md has the rest.
"""
import enum as _enum
import functools as _functools
import json as _json
import os as _os

from ._kilotouch import (MODES, DeviceReading, Frame, InputError, Mesh, PushedDevice, RunError, Session, State, Status, Touch,
                         Trace, __version__, check_model, load_mesh)
from . import _kilotouch

__all__ = ["MODES", "DeviceReading", "Flag", "Frame", "InputError", "Mesh", "Model", "PushedDevice", "RunError", "Scene",
           "Session", "State", "Status", "Touch", "Trace", "View", "check_model", "height", "load_mesh", "plot", "press", "view"]

Flag = _enum.IntFlag("Flag", _kilotouch._flags, module=__name__)
Flag.__doc__ = "The reasons of a force, bits of Frame.flags. docs/embedding.md has their meaning."
Frame.flags = property(lambda self: Flag(self._flags), doc="the reasons of the force, kilotouch.Flag")


def _told_in_one_line(owner, name):
    """Wrong arguments in one line. pybind11 takes several, with types of C++."""
    function = getattr(owner, name)
    said = owner.__name__ if name == "__init__" else f"{owner.__name__}.{name}" if isinstance(owner, type) else name

    @_functools.wraps(function)
    def call(*arguments, **named):
        try:
            return function(*arguments, **named)
        except TypeError as error:
            if "incompatible" not in str(error):
                raise
            given = [type(a).__name__ for a in arguments[isinstance(owner, type):]]
            given += [f"{key}={type(value).__name__}" for key, value in named.items()]
            wanted = (function.__doc__ or "").partition(" -> ")[0].partition("(")[2].rpartition(")")[0]
            wanted = ", ".join(w.partition(":")[0].strip() for w in wanted.split(", ") if not w.startswith("self"))
        raise TypeError(f"{said}({', '.join(given)}): must be {said}({wanted}); see help(kilotouch.{said})")

    setattr(owner, name, call)


for _owner, _names in ((DeviceReading, ("__init__",)), (Mesh, ("__init__", "save")), (Session, ("__init__", "run", "start")),
                       (Touch, ("__init__",)), (PushedDevice, ("push",)), (Trace, ("save",))):
    for _name in _names:
        _told_in_one_line(_owner, _name)
_told_in_one_line(_kilotouch, "load_mesh")
_told_in_one_line(_kilotouch, "check_model")
load_mesh, check_model = _kilotouch.load_mesh, _kilotouch.check_model


def _plain(value):
    """Values that json does not take, as numpy's numbers and arrays, paths."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "__fspath__"):
        return _os.fspath(value)
    raise TypeError(f"a setting is a number, a text, a list or a dict, not {type(value).__name__}")


def _setting(key, value):
    if not isinstance(key, str) or "=" in key:
        raise InputError(f"{key!r}: the key of a setting is a text without =, as contact.mu")
    return f"{key}={_json.dumps(value, default=_plain)}"


class Scene(_kilotouch.Scene):
    """A scene, with body, tool, path, settings. Keys are those of a scene file (docs/scene.md).

    `file` is a scene file. With None every setting is as by default, with the mesh that a Touch or a Session is given.
    `settings` are {"contact.mu": 0.8, "object.mesh": "liver.obj"}, as --set on the command line.
    `scene["contact.mu_static"]` reads and changes one, and is None where it is not set. contact.mu is short for mu_static
    and mu_kinetic, and None where they differ.
    InputError has file, key, value and allowed range. Nothing is changed then.
    """

    def __init__(self, file=None, settings=None):
        super().__init__(None if file is None else _os.fspath(file),
                         [_setting(key, value) for key, value in (settings or {}).items()])

    def __getitem__(self, key):
        return _json.loads(self._get(key))

    def __setitem__(self, key, value):
        self._set(_setting(key, value))

    def __contains__(self, key):
        return key in self._keys()

    def __iter__(self):
        return iter(self._keys())

    def keys(self):
        """Every key that a scene can have."""
        return self._keys()

    def to_dict(self):
        """Every key with its value, nested as in a scene file."""
        return _json.loads(self.to_json())

    def __repr__(self):
        return f"<kilotouch.Scene: {self['title'] or 'no title'}, mesh {self['object.mesh']}>"


class Model:
    """Physics of one's own, M a = force(x, v). Derive from it, and write force(), and tangent() where differences are too slow.

    `mesh` is a Mesh at rest, `mass` that of each node (n,) [kg], or scipy's sparse (3n, 3n), `fixed` indices or a mask of
    clamped nodes. It is called at the body's rate (30 Hz), never in a haptic tick, by one thread at a time. Its exceptions
    end the body's simulation. check_model() tries it.
    """

    def __init__(self, mesh, mass, fixed=()):
        import numpy
        self.mesh = mesh
        fixed = numpy.asarray(fixed)
        if fixed.dtype == bool:
            if fixed.shape != (len(mesh.x),):
                raise InputError(f"fixed: a mask of shape {fixed.shape}, must have a value a node, ({len(mesh.x)},)")
            fixed = numpy.flatnonzero(fixed)
        if fixed.size and (fixed.dtype.kind not in "iu" or fixed.ndim != 1):
            raise InputError("fixed: indices of nodes, whole numbers, or a mask of them")
        self.fixed = [int(i) for i in fixed]
        if not hasattr(mass, "tocsc"):
            import scipy.sparse
            mass = numpy.asarray(mass, float)
            if mass.ndim != 1:
                raise InputError("mass: a number a node, (n,) [kg], or scipy's sparse (3n, 3n)")
            mass = scipy.sparse.diags(numpy.repeat(mass, 3), format="csc")
        self.mass = mass.tocsc()

    def force(self, x, v):
        """Inner and outer forces (n, 3) [N] at places x (n, 3) [m] and speeds v (n, 3) [m/s]."""
        raise NotImplementedError("Model.force(x, v) is to be written")

    #: tangent(x, v, definite) gives (dfdx, dfdv), scipy's sparse (3n, 3n) [N/m], [N s/m], with `definite` -dfdx and -dfdv
    #: positive semidefinite. With None it is made by differences of force(), 300 to 600 calls.
    tangent = None


from .batch import height, press  # after InputError and the like, which it asks for where it needs them


def view(what, open=True, port=0):
    """Opens the live page of a Scene, a Mesh, a file or a run's folder, and returns it with `url` and `close()`. A cell of a notebook
    shows it.

    `open` opens it in the browser. `port` 0 takes a free one. RunError where the command `kilotouch` is missing or refuses, in its
    words.
    """
    from . import pages
    return pages.view(what, open, port)


def __getattr__(name):
    if name == "View":  # with the modules that only a page needs
        from .pages import View
        return View
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def plot(trace, other=None):
    """A matplotlib figure of a run, with normal and tangential force, stick and slip. `other` is a trace to compare with."""
    from .plots import draw
    return draw(trace, other)
