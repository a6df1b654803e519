"""Every key of a scene, from its schema, with the manual's words."""
import json
import os
import re


def ranges(schema, root):
    """What the schema allows, in words; empty for a group."""
    if "$ref" in schema:
        return ranges(root["definitions"][schema["$ref"].rsplit("/", 1)[1]], root)
    if "enum" in schema:
        return ", ".join(f"`{json.dumps(v).strip(chr(34))}`" for v in schema["enum"])
    if "anyOf" in schema or "oneOf" in schema:
        return ", or ".join(r for r in (ranges(s, root) for s in schema.get("anyOf", schema.get("oneOf"))) if r)
    kind = schema.get("type")
    if isinstance(kind, list):
        return " or ".join(kind)
    if kind in ("number", "integer"):
        low, high = schema.get("minimum"), schema.get("maximum")
        left = f"[{low:g}" if low is not None else f"({schema['exclusiveMinimum']:g}" if "exclusiveMinimum" in schema else "(−∞"
        right = f"{high:g}]" if high is not None and high < 1e15 else f"{schema['exclusiveMaximum']:g})" if "exclusiveMaximum" in schema else "∞)"
        return ("whole number in " if kind == "integer" else "number in ") + left + ", " + right
    if kind == "boolean":
        return "`true`, `false`"
    if kind == "array":
        inner = ranges(schema.get("items", {}), root) if isinstance(schema.get("items"), dict) else ""
        low, high = schema.get("minItems"), schema.get("maxItems")
        count = f"{low} " if low and low == high else ""
        return f"list of {count}{'(' + inner + ')' if inner else 'values'}"
    return {"string": "text", "object": "group"}.get(kind, "")


def leaves(schema, root, prefix=""):
    """[(key, schema)] in the order of the schema."""
    if "$ref" in schema:
        schema = root["definitions"][schema["$ref"].rsplit("/", 1)[1]]
    inner = schema.get("properties", {})
    if not inner:
        return [(prefix, schema)]
    return [leaf for name, s in inner.items() for leaf in leaves(s, root, f"{prefix}.{name}" if prefix else name)]


def manual(root):
    """{key: (default, range, meaning)} of the table in docs/scene.md."""
    out = {}
    with open(os.path.join(root, "docs", "scene.md"), encoding="utf-8") as file:
        for line in file:
            m = re.match(r"\| `([a-z_.]+)` \| (.*?) \| (.*?) \| (.*) \|$", line)
            if m:
                out[m[1]] = m.groups()[1:]
    return out


def page(root, defaults_text):
    with open(os.path.join(root, "io", "scene", "scene.schema.json"), encoding="utf-8") as file:
        schema = json.load(file)
    words, defaults = manual(root), json.loads(defaults_text) if defaults_text else {}
    out = ["# Scene keys", "", "Made from the schema of scenes, the defaults of the code and the words of [scene.md](/docs/scene.md). "
           "`second_tool` has the keys of `tool`.", ""]
    group = None
    for key, s in leaves(schema, schema):
        if key.startswith("second_tool."):
            continue
        if (key.split(".")[0] if "." in key else "scene") != group:
            group = key.split(".")[0] if "." in key else "scene"
            out += [f"## {group}", ""]
        default, told, meaning = words.get(key, ("", "", s.get("description", "")))
        unit = m[1] if (m := re.match(r"(m|s|ms|us|Hz|Pa|kg|N|rad|rad/s|m/s|m/s²|m³|1/s|kg/m³|N/m|N/s|N·s/m|degrees)(?:,|$)", told)) else ""
        if key in defaults and default != "required":
            default = f"`{json.dumps(defaults[key], ensure_ascii=False)}`"
        meaning = re.sub(r"\]\(([a-z_]+\.md)", r"](../\1", meaning.replace("](../", "](../../"))
        meaning = re.sub(r"\]\(#", "](../scene" + ".md#", meaning)
        out += [f"### {key}", "", meaning or s.get("description", ""), "",
                f"- allowed: {ranges(s, schema) or 'see scene.md'}{', in ' + unit if unit else ''}", f"- default: {default or 'none'}{'; for experts' if s.get('expert') else ''}", ""]
    return "\n".join(out)
