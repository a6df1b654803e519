#!/usr/bin/python3
"""A wheel of the build: module, command, scenes, meshes, and every shared library but the C and C++ runtime.

    packaging/wheel.py BUILD OUT

The libraries lie in kilotouch.libs, under names of their own, so that no other package's library of the same name is taken
for one of them. Needs patchelf and the module wheel (Debian: patchelf, python3-wheel).
"""
import glob
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
# On every Linux with the C library of the wheel's tag (PEP 600).
OF_THE_SYSTEM = re.compile(r"(ld-linux[-\w]*|linux-vdso|lib(c|m|dl|rt|pthread|util|resolv|nsl|gcc_s|stdc\+\+))\.so")


def run(*words):
    return subprocess.run(words, check=True, capture_output=True, text=True).stdout


def needed(file):
    """{name that `file` asks for, directly or not: where it is}."""
    found = {}
    for line in run("ldd", file).splitlines():
        name, _, place = line.strip().partition(" => ")
        if OF_THE_SYSTEM.match(os.path.basename(name.split()[0])):
            continue
        if "not found" in place or not place:
            sys.exit(f"packaging/wheel.py: {file}: {line.strip()}")
        found[name] = os.path.realpath(place.split()[0])
    return found


def copyright_of(library):
    """Debian's file about it."""
    for place in (library, library.replace("/usr/lib", "/lib", 1)):
        owner = subprocess.run(["dpkg-query", "-S", place], capture_output=True, text=True)
        if owner.returncode == 0:
            package = owner.stdout.split(":")[0]
            file = f"/usr/share/doc/{package}/copyright"
            if os.path.exists(file):
                return package, file
    sys.exit(f"packaging/wheel.py: no package of Debian owns {library}: under which licence is it?")


def bundle(folder, files):
    """Copies what `files` need to kilotouch.libs, and has them and each other find it there.    @returns {package: copyright}"""
    places, notices = {}, {}
    for file in files:
        places.update(needed(file))
    libraries = os.path.join(folder, "kilotouch.libs")
    os.makedirs(libraries)
    names = {}
    for name, place in places.items():
        with open(place, "rb") as content:
            digest = hashlib.sha256(content.read()).hexdigest()[:8]
        stem, _, ending = name.partition(".so")
        names[name] = f"{stem}-{digest}.so{ending}"
        shutil.copy(place, os.path.join(libraries, names[name]))
        package, notice = copyright_of(place)
        notices[package] = notice
    for name, own in names.items():
        run("patchelf", "--set-soname", own, os.path.join(libraries, own))
    for file in [*files, *(os.path.join(libraries, own) for own in names.values())]:
        os.chmod(file, 0o755)
        asked = run("patchelf", "--print-needed", file).split()
        replaced = [word for name in asked if name in names for word in ("--replace-needed", name, names[name])]
        here = os.path.relpath(libraries, os.path.dirname(file))
        if replaced:  # in a step of its own: patchelf 0.14 writes both into one place
            run("patchelf", *replaced, file)
        run("patchelf", "--set-rpath", "$ORIGIN" if here == "." else f"$ORIGIN/{here}", file)
    return notices


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    build, out = map(os.path.abspath, sys.argv[1:])
    with tempfile.TemporaryDirectory() as work:
        for component in ("program", "python"):
            run("cmake", "--install", build, "--component", component, "--prefix", os.path.join(work, "made"), "--strip")
        wheel, made = os.path.join(work, "wheel"), os.path.join(work, "made")
        package = os.path.join(wheel, "kilotouch")
        module_folder, = glob.glob(os.path.join(made, "lib", "python3*", "*-packages", "kilotouch"))
        shutil.copytree(module_folder, package)
        os.makedirs(os.path.join(package, "bin"))
        shutil.copy(os.path.join(made, "bin", "kilotouch"), os.path.join(package, "bin"))
        shutil.copytree(os.path.join(made, "share", "kilotouch"), os.path.join(package, "share", "kilotouch"))
        module, = glob.glob(os.path.join(package, "_kilotouch*.so"))
        program = os.path.join(package, "bin", "kilotouch")
        version, _, licence = run(program, "--version").strip().partition("\nlicence of this build: ")
        notices = bundle(wheel, [module, program])
        write_info(wheel, version, licence, notices, build)
        os.makedirs(out, exist_ok=True)
        print(run(sys.executable, "-m", "wheel", "pack", wheel, "--dest-dir", out).splitlines()[-1])


def write_info(wheel, version, licence, notices, build):
    info = os.path.join(wheel, f"kilotouch-{version}.dist-info")
    licences = os.path.join(info, "licenses")
    os.makedirs(licences)
    for name in ("LICENSE", "NOTICE"):
        shutil.copy(os.path.join(ROOT, name), licences)
    shutil.copy(os.path.join(build, "packaging", "licences_of_others"), licences)
    for package, notice in notices.items():
        shutil.copy(notice, os.path.join(licences, package))
    with open(os.path.join(ROOT, "packaging", "METADATA.in"), encoding="utf-8") as file:
        metadata = file.read().replace("@VERSION@", version).replace("@LICENCE@", licence)
    tag = sysconfig.get_config_var("py_version_nodot")
    glibc = platform.libc_ver()[1].replace(".", "_")
    texts = {"METADATA": metadata,
             "WHEEL": f"Wheel-Version: 1.0\nGenerator: kilotouch packaging/wheel.py\nRoot-Is-Purelib: false\n"
                      f"Tag: cp{tag}-cp{tag}-manylinux_{glibc}_{platform.machine()}\n",
             "entry_points.txt": "[console_scripts]\nkilotouch = kilotouch.program:main\n",
             "top_level.txt": "kilotouch\n"}
    for name, text in texts.items():
        with open(os.path.join(info, name), "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    main()
