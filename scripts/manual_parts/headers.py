"""C and C++: the declarations of installed headers with their comments, as pages."""
import os
import re


def c_page(root):
    with open(os.path.join(root, "api", "kilotouch.h"), encoding="utf-8") as file:
        text = file.read()
    about, rest = re.match(r"/\* ?(.*?) ?\*/\n(.*)", text, re.S).groups()
    about = re.sub(r"(?m)^ \* ?", "", about)
    body = rest[rest.index("#define KT_API_VERSION"):rest.rindex("#ifdef __cplusplus")]
    out = ["# C", "", about, "", "[embedding.md](/docs/embedding.md) shows its use, [c_loop.c](/examples/c_loop.c) is a whole program. "
           "Below is `kilotouch.h` as it is installed.", ""]
    blocks = re.split(r"\n\n+", body.strip())
    for block in blocks:
        names = re.findall(r"\b(kt_\w+)\(|}\s*(kt_\w+);|struct (kt_\w+)|(?:define|^  |\{) ?(KT_\w+)", block, re.M)
        names = list(dict.fromkeys(n for found in names for n in found if n and n != "kt_last_error_"))
        names = [n for n in names if n.startswith("kt_")] or names[:1]
        out += [f"## {', '.join(names)}", "", "```c", block, "```", ""]
    return "\n".join(out)


def included(root):
    """The installed headers: what kilotouch.hpp includes, and what these include."""
    todo, seen = ["api/kilotouch.hpp"], []
    while todo:
        name = todo.pop(0)
        if name in seen:
            continue
        seen.append(name)
        with open(os.path.join(root, name), encoding="utf-8") as file:
            todo += [n for n in re.findall(r'#include "([^"]+)"', file.read()) if os.path.exists(os.path.join(root, n))]
    return seen


def declarations(text):
    """Declarations at column 0 with the comment above, without private parts and bodies of functions."""
    out, block, depth = [], [], 0
    for line in text.split("\n"):
        if not depth and (line.startswith(("#", "namespace", "}  // namespace", "using namespace")) or not line.strip() or
                          (line.startswith("// ") and not block)):
            block = [] if not line.strip() or not block or not block[-1].startswith("///") else block
            continue
        block.append(line)
        depth += line.count("{") - line.count("}") + line.count("(") - line.count(")")
        if depth <= 0 and not line.startswith("///") and line.rstrip().split("  //")[0].endswith((";", "}")):
            out.append(re.sub(r"\n (private|protected):.*?(?=\n};)", "", "\n".join(block), flags=re.S))
            block, depth = [], 0
    return out


def title_of(block):
    code = "\n".join(line for line in block.split("\n") if not line.startswith("///"))
    m = re.match(r"(?:template <[^>]*>\s*)?(?:class|struct|enum class|enum|union) (\w+)(?: final)?\s*(?::|{)", code)
    return f"kt::{m[1]}" if m else None


def cpp_page(root):
    out = ["# C++", "", "What `#include <kilotouch/kilotouch.hpp>` declares, made from the headers. "
           "[embedding.md](/docs/embedding.md) shows its use; the [first program](/docs/tutorials/own_body.md) is a tutorial.", ""]
    first = ["haptics/touch/touch.hpp", "haptics/body/body.hpp", "haptics/options/touch_options.hpp", "haptics/tick/local_frame.hpp"]
    names = included(root)
    for name in [n for n in first if n in names] + [n for n in names if n not in first]:
        with open(os.path.join(root, name), encoding="utf-8") as file:
            found = declarations(file.read())
        found = [b for b in found if not re.match(r"(class|struct) \w+;|static_assert", b)]
        if not found:
            continue
        out += [f"## {name}", ""]
        loose = [b for b in found if not title_of(b)]
        for block in found:
            if title_of(block):
                out += [f"### {title_of(block)}", "", "```cpp", block, "```", ""]
        if loose:
            out += [f"### Functions and values of {os.path.basename(name)}", "", "```cpp", "\n".join(loose), "```", ""]
    return "\n".join(out)
