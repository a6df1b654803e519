"""Reference pages that are made from the code: scene keys, C, C++, Python."""
import os
import subprocess
import sys

import headers
import scene_keys


def pages(root, build):
    """{page: text} and what could not be made."""
    made = {"c": headers.c_page(root), "cpp": headers.cpp_page(root)}
    left_out = []
    folder = os.path.join(build, "python")
    if os.path.isdir(os.path.join(folder, "kilotouch")):
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "python_page.py")
        done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True,
                              env=dict(os.environ, PYTHONPATH=folder, PYTHONDONTWRITEBYTECODE="1"))
        made["python"], _, defaults = done.stdout.rpartition("\n\f")
    else:
        left_out.append(f"the Python reference and the defaults of scene keys: no Python package in {folder}; "
                        "cmake --build build/release --target kt_python")
        defaults = ""
    made["scene_keys"] = scene_keys.page(root, defaults)
    return {f"docs/reference/{name}" + ".md": text for name, text in made.items()}, left_out
