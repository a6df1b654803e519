"""The pages of the site in one folder: those of the repository as they are, pages of the files that they link to, made ones."""
import fnmatch
import json
import os
import re
import shutil
import subprocess

LINK = re.compile(r"(\]\()([^()#\s:]+)((?:#[^()\s]+)?\))")
LANGUAGES = {".cpp": "cpp", ".hpp": "cpp", ".c": "c", ".h": "c", ".py": "python", ".json": "js", ".css": "css", ".cs": "csharp"}


def pages_of(root):
    """Markdown files of the repository, from its root."""
    listed = subprocess.run(["git", "-C", root, "ls-files", "--cached", "--others", "--exclude-standard", "*.md"], capture_output=True, text=True)
    names = listed.stdout.split("\n") if listed.returncode == 0 else []
    return sorted(n for n in names if n and os.path.exists(os.path.join(root, n)))


def navigation(root, made):
    """[(caption, [page])] in the order of navigation.json; pages that are not there are left out."""
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "navigation.json"), encoding="utf-8") as file:
        parts = json.load(file)
    there = sorted({*pages_of(root), *made})
    return [(caption, [name for pattern in patterns for name in fnmatch.filter(there, pattern)]) for caption, patterns in parts]


def page_of_file(root, name):
    """A file of the repository, or the names in a folder, as a page."""
    path = os.path.join(root, name)
    if os.path.isdir(path):
        text = "\n".join(f"- {n}" for n in sorted(os.listdir(path)) if not n.startswith((".", "__")))
        return f"---\norphan: true\n---\n# {name}/\n\n{text}\n"
    with open(path, encoding="utf-8", errors="replace") as file:
        lines = file.read().rstrip("\n")
    language = LANGUAGES.get(os.path.splitext(name)[1], "bash" if lines.startswith("#!") else "text")
    return f"---\norphan: true\n---\n# {name}\n\n`````{language}\n{lines}\n`````\n"


def with_links(root, name, text, shown):
    """Links to files that are no pages lead to pages of them."""
    folder = os.path.dirname(name)

    def to_page(m):
        to = m[2][1:] if m[2].startswith("/") else os.path.normpath(os.path.join(folder, m[2]))
        if m[2].endswith((".md", ".png", ".webp", ".svg")) or to.startswith("..") or not os.path.exists(os.path.join(root, to)):
            return m[0]
        shown.add(to)
        return f"{m[1]}{os.path.relpath('files/' + to + '.md', folder or '.')})"

    return LINK.sub(to_page, text)


def put(path, text):
    """Sphinx reads again what is newer: equal texts keep their time."""
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            if file.read() == text:
                return
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def without_import(css):
    """Debian's furo takes normalize.css from a web server's folder, which a file has not: manual.css has what pages need of it."""
    with open(css, encoding="utf-8") as file:
        text = file.read()
    with open(css, "w", encoding="utf-8") as file:
        file.write(re.sub(r"@import [^;]*;", "", text))


def write(root, source, made):
    parts = navigation(root, made)
    wanted, shown = {}, set()
    for name in sorted({n for _, names in parts for n in names} | {"docs/index.md"}):
        if name in made:
            text = made[name]
        else:
            with open(os.path.join(root, name), encoding="utf-8") as file:
                text = file.read()
        wanted[name] = with_links(root, name, text, shown)
    for caption, names in parts:
        entries = "\n".join("/" + os.path.splitext(n)[0] for n in names)
        wanted["docs/index.md"] += f"\n```{{toctree}}\n:caption: {caption}\n:hidden:\n\n{entries}\n```\n"
    for name in sorted(shown):
        wanted[f"files/{name}.md"] = page_of_file(root, name)
    for folder, _, files in os.walk(source, topdown=False):
        for file in files:
            if os.path.relpath(os.path.join(folder, file), source) not in wanted:
                os.remove(os.path.join(folder, file))
    for name, text in wanted.items():
        put(os.path.join(source, name), text)
    shutil.copytree(os.path.join(root, "docs", "pictures"), os.path.join(source, "docs", "pictures"), dirs_exist_ok=True)
