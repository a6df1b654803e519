"""What a result folder holds."""
import csv
import json
import os

from report_parts.drawing import CAN_DRAW, np


def read_json(folder, name):
    """The file's content, or None when there is no such file. A damaged file is an error that names it."""
    path = os.path.join(folder, name)
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as file:
        try:
            return json.load(file)
        except ValueError as error:
            raise SystemExit(f"report.py: {path}: {error}")


def read_trace(folder, name="trace.csv"):
    """Columns of trace.csv by name: floats as arrays, mode as an array of words. None without the file or a row."""
    path = os.path.join(folder, name)
    if not CAN_DRAW or not os.path.exists(path):
        return None
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.reader(line for line in file if not line.startswith("#"))
        names = [column.strip() for column in next(rows, [])]
        columns = list(zip(*(row for row in rows if len(row) == len(names))))  # a killed run may end in half a row
    if not columns or len(columns[0]) < 3:  # nothing to draw
        return None
    trace = {}
    for column_name, column in zip(names, columns):
        try:
            trace[column_name] = np.array(column) if column_name == "mode" else np.array(column, dtype=float)
        except ValueError:
            raise SystemExit(f"report.py: {path}: column {column_name} holds a word that is not a number")
    return trace


class Run:
    """Everything one result folder holds."""

    def __init__(self, folder):
        self.folder = folder
        self.trace = read_trace(folder)
        self.second_trace = read_trace(folder, "trace_2.csv")  # of a second tool
        self.reference = read_trace(folder, "reference.csv")
        self.summary = read_json(folder, "summary.json") or {}
        self.view = read_json(folder, "view.json")
        self.scene = read_json(folder, "scene.json") or {}
        self.name = os.path.basename(os.path.abspath(folder))

    @property
    def is_empty(self):
        return self.trace is None and not self.summary and self.view is None

    def setting(self, group, key):
        """A setting from scene.json, else from summary.json."""
        for source in (self.scene, self.summary.get("settings"), self.summary):
            if isinstance(source, dict) and isinstance(source.get(group), dict) and key in source[group]:
                return source[group][key]
        return None

    def friction(self):
        """(static, kinetic) coefficients, or None."""
        mu = self.setting("contact", "mu")
        pair = (self.setting("contact", "mu_static"), self.setting("contact", "mu_kinetic"))
        return pair if None not in pair else (mu, mu) if mu is not None else None
