"""Files that appear whole or not at all."""
import os
import tempfile


def write_whole(path, content):
    """Text or bytes: beside `path` under a name of chance, to the disk, then renamed."""
    data = content.encode("utf-8", "replace") if isinstance(content, str) else content
    file, temporary = tempfile.mkstemp(prefix=".kilotouch-", dir=os.path.dirname(path) or ".")
    try:
        with os.fdopen(file, "wb") as out:
            out.write(data)
            out.flush()
            os.fsync(out.fileno())
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def save_figure(figure, path):
    """As figure.savefig(path)."""
    import io
    out = io.BytesIO()
    figure.savefig(out, format=os.path.splitext(path)[1][1:])
    write_whole(path, out.getvalue())
