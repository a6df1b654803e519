"""A soft organ in the browser, with the tool at the mouse. Ctrl-C ends it.

    python -m kilotouch.demo [options of `kilotouch view`]          as --port 8000, --no-open
"""
import sys

from . import program


def main():
    arguments = sys.argv[1:]
    if arguments and arguments[0] in ("-h", "--help"):
        print(__doc__.strip())
        return
    opened = [] if "--no-open" in arguments else ["--open"]
    program.run(["view", *opened, *(a for a in arguments if a != "--no-open")])


if __name__ == "__main__":
    main()
