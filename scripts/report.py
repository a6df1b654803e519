#!/usr/bin/python3
"""Pictures and self-contained HTML pages from a result folder of `kilotouch`.

    report.py DIR [--title T] [--figures svg|pdf]
                                   DIR/force.png, mesh.png, report.html; the pictures as vectors, too
    report.py --paper DIR          DIR/paper.png, paper.html
    report.py --chart DIR          DIR/chart.html, chart_*.png, chart_*.svg from DIR/chart.json
    report.py --stability DIR      DIR/<map>.png, <map>.svg, stability.html
    report.py --check DIR          DIR/report.html from its report.json (kilotouch check)
    report.py --compare DIR        DIR/compare.html from its compare.json (kilotouch compare)

Reads DIR/trace.csv, summary.json, view.json and scene.json; each may be missing, and what needs it is then left out.
Pictures and curves need numpy and matplotlib (Debian: python3-matplotlib), pages Jinja2 (python3-jinja2). Without one of
them there is all that needs it not, one line says what is missing, and the exit status is 3. The charts of pages need
libjs-chart.js and the player libjs-three: without them the pages hold still pictures.
Units are SI in the files; the pictures use mm, s, N and microseconds.
"""
import argparse
import os
import sys

sys.dont_write_bytecode = True  # the folder may be one that others use

from report_parts.chart import chart_report
from report_parts.check_page import check_page
from report_parts.compare_page import compare_page
from report_parts.drawing import CAN_DRAW, plt
from report_parts.pages import jinja2
from report_parts.paper import paper_report
from report_parts.run_page import report
from report_parts.stability import stability_report
from report_parts.style import STYLE


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="DIR")
    parser.add_argument("--title")
    parser.add_argument("--figures", choices=("svg", "pdf"), help="of a run: force and mesh in this format, too")
    parser.add_argument("--paper", action="store_true", help="DIR holds slide, stick, stick_slip, the same _extended, coulomb_slide and coulomb")
    parser.add_argument("--chart", action="store_true", help="DIR holds the chart.json of kilotouch chart")
    parser.add_argument("--stability", action="store_true", help="DIR holds stability.json and the maps' tables")
    parser.add_argument("--check", action="store_true", help="DIR holds what kilotouch check left")
    parser.add_argument("--compare", action="store_true", help="DIR holds the compare.json of kilotouch compare")
    arguments = parser.parse_args()
    try:
        return draw(arguments)
    except OSError as error:  # a full disk: one line, and what was whole before is as it was
        raise SystemExit(f"report.py: {error.filename or arguments.folder}: {error.strerror or error}")


def draw(arguments):
    if not os.path.isdir(arguments.folder):
        raise SystemExit(f"report.py: {arguments.folder}: no such folder")
    if CAN_DRAW:
        plt.rcParams.update(STYLE)
    if arguments.chart:
        chart_report(arguments.folder)
    elif arguments.check:
        check_page(arguments.folder)
    elif arguments.paper:
        paper_report(arguments.folder, arguments.title)
    elif arguments.stability:
        stability_report(arguments.folder, arguments.title)
    elif arguments.compare:
        compare_page(arguments.folder)
    else:
        report(arguments.folder, arguments.title, arguments.figures)
    missing = [] if CAN_DRAW else ["no pictures: numpy or matplotlib is missing (Debian: python3-matplotlib)"]
    missing += [] if jinja2 else ["no page: Jinja2 is missing (Debian: python3-jinja2)"]
    if missing:
        print(f"report.py: {'; '.join(missing)}; the numbers are in {arguments.folder}", file=sys.stderr)
    return 3 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
