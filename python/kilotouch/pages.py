"""The live page of a scene, as `kilotouch view` serves it."""
import json
import os
import re
import subprocess
import tempfile
import threading

from . import InputError, Mesh, RunError, Scene, program


class View:
    """A server of a page. `url` is its address. close() ends it, and so does the end of Python or of a `with` block."""

    url = ""  #: address of the page

    def __init__(self, server, folder, url):
        self._server, self._folder, self.url = server, folder, url

    def close(self):
        """Ends the server. Twice does nothing."""
        self._server.terminate()
        self._server.wait()
        self._server.stdout.close()
        self._folder.cleanup()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __repr__(self):
        return f"<kilotouch.View {self.url}{'' if self._server.poll() is None else ', closed'}>"

    def _repr_html_(self):
        return f'<iframe src="{self.url}" width="100%" height="600" style="border: 0"></iframe>'


def view(what, is_opened, port):
    folder = tempfile.TemporaryDirectory(prefix="kilotouch-")
    try:
        if isinstance(what, Scene):
            scene, source = what.to_dict(), os.path.join(folder.name, "scene.json")
            if scene["object"]["mesh"] == "-":
                raise InputError("object.mesh: the scene names no file, which a page needs; view() takes a Mesh, too")
            scene["object"]["mesh"] = os.path.abspath(scene["object"]["mesh"])
            with open(source, "w", encoding="utf-8") as file:
                json.dump(scene, file)
        elif isinstance(what, Mesh):
            source = os.path.join(folder.name, "mesh.vtu" if len(what.tetrahedra) else "mesh.off")
            what.save(source)
        else:
            source = os.fspath(what)
        try:
            words = [program.path(), "view", source, "--port", str(port), *(["--open"] if is_opened else [])]
        except RuntimeError as error:
            raise RunError(str(error)) from None
        server = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    except BaseException:
        folder.cleanup()
        raise
    said = ""
    for line in server.stdout:
        said += line
        found = re.search(r"https?://\S+", line)
        if found:
            threading.Thread(target=_read_on, args=(server.stdout,), daemon=True).start()
            made = View(server, folder, found[0])
            _ends_with_python(made)
            return made
    server.wait()
    server.stdout.close()
    folder.cleanup()
    raise RunError(said.strip() or "kilotouch view ended without a word")


def _read_on(pipe):
    """Reads the later lines of the server, since a full pipe would hold it up."""
    try:
        for _ in pipe:
            pass
    except ValueError:  # closed
        pass


def _ends_with_python(made):
    import atexit
    atexit.register(lambda: made._server.poll() is None and made.close())
