"""What the scripts share that measure: the build, runs of the program, results as CSV files, tables between the markers of pages."""
import csv
import json
import os
import re
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))


def build(*targets):
    subprocess.run(["cmake", "--preset", "release"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", "--preset", "release", "--target", *targets], check=True)


def set_words(sets):
    """KEY=VALUE, ... as words of a command."""
    return [word for one in sets for word in ("--set", one)]


def machine():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    return f"{names[0] if names else 'unknown CPU'}, {os.cpu_count()} cores; commit {commit or 'unknown'}"


def read_json(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def read_csv(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def write_csv(path, origin, rows):
    with open(path, "w", newline="", encoding="utf-8") as file:
        file.write(f"# {origin}\n")
        writer = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def read_forces(folder):
    """Force on the tool [N] by tick."""
    return [tuple(float(row[f"force_{axis}"]) for axis in "xyz") for row in read_csv(os.path.join(folder, "trace.csv"))]


def percent(value):
    """Two figures are enough, and more than machines agree on."""
    return f"{100 * value:.2g} %" if value < 0.095 else f"{100 * value:.0f} %"


def table(head, rows):
    """In Markdown."""
    lines = ["| " + " | ".join(map(str, line)) + " |" for line in [head, *rows]]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def put_between(document, name, text):
    """Between the markers <!-- NAME begin --> and <!-- NAME end --> of a page."""
    begin, end = f"<!-- {name} begin -->", f"<!-- {name} end -->"
    with open(document, encoding="utf-8") as file:
        page = file.read()
    if page.count(begin) != 1 or page.count(end) != 1 or page.index(begin) > page.index(end):
        sys.exit(f'{document}: needs the lines "{begin}" and "{end}", in this order and once each')
    page = re.sub(re.escape(begin) + ".*?" + re.escape(end), lambda _: f"{begin}\n\n{text.strip()}\n\n{end}", page, flags=re.S)
    with open(document + ".part", "w", encoding="utf-8") as file:
        file.write(page)
    os.replace(document + ".part", document)
