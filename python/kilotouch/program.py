"""The command `kilotouch`, which the wheel brings along, and Debian's package kilotouch puts on the path."""
import os
import shutil
import sys


def path():
    """The file of the command. RuntimeError where it is not installed."""
    own = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bin", "kilotouch")
    found = own if os.path.exists(own) else shutil.which("kilotouch")
    if not found:
        raise RuntimeError("the command kilotouch is neither in this package nor on the path: install the package kilotouch")
    return found


def run(arguments):
    """Becomes the command. Does not return."""
    try:
        os.execv(path(), ["kilotouch", *arguments])
    except (RuntimeError, OSError) as error:
        sys.exit(f"kilotouch: {error}")


def main():
    run(sys.argv[1:])
