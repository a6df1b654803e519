"""Prints the Python reference from docstrings, then a form feed, then the defaults of scene keys as JSON."""
import enum
import inspect
import json

import kilotouch as kt


def doc(thing):
    """The docstring; of pybind11's functions without their first line, which is the signature."""
    text = inspect.getdoc(thing) or ""
    signature = ""
    if text.split("\n")[0].endswith((")", ": ...")) or " -> " in text.split("\n")[0]:
        signature, _, text = text.partition("\n")
    return signature.strip(), text.strip()


def entry(name, thing, level):
    signature, text = doc(thing)
    if not signature and callable(thing):
        try:
            signature = name.rpartition(".")[2] + str(inspect.signature(thing))
        except (TypeError, ValueError):
            pass
    out = [f"{'#' * level} {name}", ""]
    if signature:
        out += ["```python", signature, "```", ""]
    return out + ([text, ""] if "::" not in text and ">>>" not in text and "\n  " not in text else ["```text", text, "```", ""])


def flat(value, prefix=""):
    if isinstance(value, dict) and value:
        return {k: v for name, inner in value.items() for k, v in flat(inner, f"{prefix}.{name}" if prefix else name).items()}
    return {prefix: value}


out = ["# Python", "", "Made from the docstrings. [python.md](/docs/python.md) shows the package in use.", ""]
for name in sorted(kt.__all__, key=str.lower):
    thing = getattr(kt, name)
    if isinstance(thing, enum.EnumMeta):
        out += [f"## kt.{name}", "", doc(thing)[1], "", "| name | value |", "|---|---|", *(f"| `{m.name}` | {m.value} |" for m in thing), ""]
        continue
    out += entry(f"kt.{name}", thing, 2)
    if inspect.isclass(thing):
        for member in sorted(n for n in dir(thing) if not n.startswith("_")):
            value = inspect.getattr_static(thing, member)
            if isinstance(thing, type) and hasattr(Exception, member) or hasattr(int, member):
                continue
            got = getattr(thing, member, value)
            _, text = doc(value if isinstance(value, property) else got)
            if text or callable(got):
                out += entry(f"{name}.{member}", value if isinstance(value, property) else got, 3)
print("\n".join(out) + "\n\f" + json.dumps(flat(kt.Scene().to_dict())))
