"""summary.json as tables of words and numbers."""
import math
import re


def figures(value, digits=3):
    """Three significant figures without an exponent where a person would not write one."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    if not isinstance(value, float):
        return str(value)
    if not math.isfinite(value):
        return str(value)
    if value == 0:
        return "0"
    if 1e-3 <= abs(value) < 1e5:
        decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))  # 0.0479, 5.23, 120
        return f"{value:.{decimals}f}"
    return f"{value:.{digits - 1}e}".replace("e-0", "e-").replace("e+0", "e")


def percent(value):
    return figures(100.0 * value) + " %"


def with_unit(unit_name, factor=1.0):
    return lambda value: f"{figures(factor * value if factor != 1.0 else value)} {unit_name}".strip()


def with_floor(unit_name, steps):
    """A size in the unit that suits it. `steps`: (factor, prefix) from large to small; what is less than the last is told as such:
    9.9e-13 m says "< 1 nm", as no digit of it means anything."""
    def write(value):
        size = abs(value)
        if size == 0 or not math.isfinite(size):
            return f"{figures(float(value))} {unit_name}"
        for factor, prefix in steps:
            if size * factor >= 1:
                return f"{figures(float(factor * value))} {prefix}{unit_name}"
        return f"< 1 {steps[-1][1]}{unit_name}"
    return write


LENGTH = with_floor("m", [(1e3, "m"), (1e6, "µ"), (1e9, "n")])
ENERGY = with_floor("J", [(1, ""), (1e3, "m"), (1e6, "µ"), (1e9, "n")])
FORCE = lambda value: f"{figures(value)} N" if value == 0 or abs(value) >= 1e-6 or not math.isfinite(value) else "< 1 µN"
PLAIN = with_unit("")
ROWS = [  # (group, [(key in summary.json, name, how to write it, what it means)])
    ("Force on the tool", [
        ("force.mean_n", "normal force, mean", FORCE, "pushes the tool out of the surface; over the steady drag"),
        ("force.max_n", "normal force, largest", FORCE, ""),
        ("force.mean_t", "tangential force, mean", FORCE, "resists the drag"),
        ("force.max_t", "tangential force, largest", FORCE, ""),
        ("force.max_t_over_mu_n", "use of the friction cone", PLAIN, "largest tangential force over µ × normal force; Coulomb friction allows at most 1"),
        ("force.felt_t_over_mu_n", "… by the force that is felt", PLAIN, "the same of the force written to the device, in ticks with one contact; the fade from one local model to the next may pass 1"),
        ("force.buzz", "buzz", percent, "vibration above 100 Hz over the mean force; people notice forces that differ by 7–10 %"),
        ("force.crossing_jump", "jump at a mesh line", percent, "largest change in one tick when the contact enters another triangle, over the mean force"),
        ("force.refresh_jump", "jump at a new local model", percent, "the same when the slow side delivers a new model"),
    ]),
    ("The mesh at the contact", [
        ("mesh_at_contact.cell_m", "cell of the surface under the tool", with_unit("mm", 1e3), "side of a square of two triangles"),
        ("mesh_at_contact.contact_radius_m", "radius of the contact", with_unit("mm", 1e3), "by Hertz, where the tool is deep"),
        ("mesh_at_contact.cell_over_contact_radius.mean", "cell over contact radius", PLAIN, "mean along the path; below 0.7 the mesh adds less than a quarter (4-node elements)"),
        ("mesh_at_contact.refined_over_contact_radius", "refined cell over contact radius", PLAIN, "median over refreshes; up to 1.65 the force is near the continuum's"),
        ("mesh_at_contact.force_factor", "force over the continuum's, expected", with_unit(""), "by the mesh alone, a fit to presses at rest; 1 is right"),
    ]),
    ("Contact", [
        ("ticks.total", "ticks", PLAIN, "steps of the fast side"),
        ("ticks.free", "… without contact", PLAIN, ""),
        ("ticks.stick", "… sticking", PLAIN, "the surface follows the tool"),
        ("ticks.slide", "… sliding, no friction", PLAIN, ""),
        ("ticks.frictional_slide", "… sliding with friction", PLAIN, ""),
        ("crossings", "triangles entered", PLAIN, "times the contact went from one triangle to the next"),
        ("lost_contacts", "contacts lost", PLAIN, "the tool passed an edge and no triangle was found there; should be 0"),
        ("missed_impacts", "impacts missed", PLAIN, "found by the check against the whole body only; must be 0"),
        ("free_ticks_inside", "… ticks inside without contact", PLAIN, "the force is 0 there and should not be"),
        ("edge_ticks", "ticks at the patch's edge", PLAIN, "the tool was beyond the local model: contact goes on, coarsely"),
        ("contact_solver.unsolved_ticks", "ticks not solved exactly", PLAIN, "their forces meet Coulomb's law to less than six digits"),
        ("penetration_max_m", "deepest penetration", LENGTH, "of the tool below the deformed surface at the end of a tick"),
        ("energy_min_j", "least energy taken from the hand", ENERGY, "negative: the device was given energy"),
    ]),
    ("Time", [
        ("step_us.p50", "haptic tick, median", with_unit("µs"), "processor time; at 1 kHz there are 1000 µs"),
        ("step_us.p99", "… 99 of 100 are below", with_unit("µs"), ""),
        ("step_us.p999", "… 999 of 1000 are below", with_unit("µs"), ""),
        ("step_us.max", "… slowest", with_unit("µs"), "a shared machine may stall a single tick"),
        ("deadline_misses", "ticks over their time", PLAIN, ""),
        ("allocations_per_tick", "memory allocations per tick", PLAIN, "must be 0: an allocation can wait for the system"),
        ("global_ms.p50", "global step, median", with_unit("ms"), "of the whole object"),
        ("global_ms.p99", "… 99 of 100 are below", with_unit("ms"), ""),
        ("global_ms.max", "… slowest", with_unit("ms"), ""),
        ("refresh_ms.p50", "new local model, median", with_unit("ms"), "linearize and reduce"),
        ("refresh_ms.p99", "… 99 of 100 are below", with_unit("ms"), ""),
        ("real_time.refresh_ms_p50", "refresh, both together, median", with_unit("ms"), ""),
        ("real_time.refresh_budget_ms", "time that there is for it", with_unit("ms"), "1 / global.rate_hz"),
        ("real_time.refresh_share", "share of it", percent, ""),
        ("real_time.refresh_hz", "refreshes a second", PLAIN, "early ones included"),
        ("real_time.slow_part", "what takes longest", PLAIN, ""),
    ]),
    ("Models", [
        ("model.type", "global model", PLAIN, ""),
        ("model.material", "material", PLAIN, ""),
        ("model.nodes", "nodes", PLAIN, ""),
        ("model.tets", "tetrahedra", PLAIN, ""),
        ("model.springs", "springs", PLAIN, ""),
        ("model.triangles", "surface triangles", PLAIN, ""),
        ("local.reducer", "local model", PLAIN, "how the fast side's model is cut out of the global one"),
        ("local.dof", "unknowns of the local model", PLAIN, ""),
        ("local.patch_vertices", "surface nodes of the local model", PLAIN, ""),
        ("local.certified_error", "error of the local model's impedance, at worst", percent, "against the full model at the body's last step, the worst of 0–500 Hz: no error of the force"),
        ("local.expected_force_error", "force error of the local model alone", percent, "when it was made, at the rates of this run; without lateness, swing and what the body does until the next one"),
        ("local.reason", "why this local model", PLAIN, ""),
    ]),
    ("The body's contacts with itself", [
        ("self_contact.contacts", "most pairs in contact", PLAIN, "vertex and triangle, or two edges, nearer than the reach"),
        ("self_contact.nearest_m", "nearest pair", LENGTH, "never 0: the surface does not pass through itself"),
        ("self_contact.normal_n", "largest sum of normal forces", FORCE, ""),
        ("self_contact.mean_normal_n", "… mean", FORCE, "of all global steps"),
        ("self_contact.intersections", "triangles that cross", PLAIN, "after any global step; must be 0"),
    ]),
    ("Against the reference", [
        ("reference.force_error", "force error", percent, "over the whole run, against the full model with a fine step"),
        ("reference.jnd_fraction", "time with a noticeable error", percent, "share of the run in which the force is off by more than 10 %"),
        ("truth.force_error", "force error against the truth", percent, "the forces given with --truth"),
    ]),
]
HEAD_KEYS = ("scene", "seed", "hash", "warnings", "notes", "findings", "trust", "real_time", "command", "settings", "contact")


def look_up(data, dotted):
    for part in dotted.split("."):
        if not isinstance(data, dict) or part not in data:
            return None
        data = data[part]
    return data


def leaves(data, prefix=""):
    """(dotted key, value) of all that is not a group."""
    for key, value in data.items():
        name = f"{prefix}{key}"
        if isinstance(value, dict):
            yield from leaves(value, name + ".")
        else:
            yield name, value


# What a person notices of a force, and the setting that cures it where the run's own reasons name none. People tell forces apart that
# differ by 7 to 10 %; key -> (words that a reason of the run's `trust` has, cures). A cure "set KEY to VALUE" that the run has is left out.
PERHAPS, SURELY = 0.07, 0.10
FINER = "take finer cells (object.tetrahedralize.max_edge, or another object.mesh)"
NOTICEABLE = {
    "force.buzz": ("buzzes above 100 Hz", ["raise object.model.damping.stiffness", FINER]),
    "force.crossing_jump": ("at an edge of", ["set contact.surface to loop", FINER]),
    "force.refresh_jump": ("when a local", ["set local.blend_ms to 12", "raise global.rate_hz", "move the tool more slowly"]),
    "local.expected_force_error": ("", ["set local.reducer to condensed", "lower local.tolerance"]),
    "reference.force_error": ("", ["raise global.rate_hz", "lower local.tolerance", "move the tool more slowly"]),
    "truth.force_error": ("", [FINER, "set object.model.element to tet10", "raise global.rate_hz"]),
    "mesh_at_contact.force_factor": ("cells of", [FINER]),
}


def is_in_force(summary, cure):
    """The run's settings have what "set KEY to VALUE" asks for."""
    match = re.fullmatch(r"set (\S+) to (\S+)", cure)
    value = look_up(summary, "settings." + match[1]) if match else None
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"{value:g}" == match[2]
    return value is not None and str(value) == match[2]


def noticed(summary, key):
    """(is it noticed: "", "perhaps" or "yes"; the setting that cures it) of a number of summary.json."""
    value = look_up(summary, key)
    if key not in NOTICEABLE or not isinstance(value, (int, float)) or not math.isfinite(value):
        return "", ""
    size = abs(value - 1) if key == "mesh_at_contact.force_factor" else abs(value)
    if size <= PERHAPS:
        return "", ""
    words, cures = NOTICEABLE[key]
    cure = ", or ".join(cure for cure in cures if not is_in_force(summary, cure))
    for reason in (look_up(summary, "trust.reasons") or []):
        if words and words in str(reason.get("what")) and reason.get("cure"):
            cure = str(reason["cure"])
    return "yes" if size > SURELY else "perhaps", cure


def written(value, write):
    """A cell: empty for what was not measured; a word stays a word where a number was due."""
    if value is None or value == "":
        return "–"
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return write(value) if is_number else figures(value)


def summary_groups(runs):
    """The known numbers in groups: title and rows, each with its name, a text for every run, what it means, and of the first run
    whether a person notices it and the cure. Groups and rows that no run has are left out."""
    out = []
    for title, rows in ROWS:
        lines = []
        for key, name, write, meaning in rows:
            values = [look_up(run.summary, key) for run in runs]
            if all(value in (None, "") for value in values):
                continue
            level, cure = noticed(runs[0].summary, key)
            lines.append({"name": name, "cells": [written(value, write) for value in values], "meaning": meaning, "noticed": level, "cure": cure})
        if lines:
            out.append({"title": title, "rows": lines})
    return out


def other_numbers(summary):
    """[(key, text)] of what has no words above."""
    known = {key for _, rows in ROWS for key, *_ in rows}
    return [(key, written(value, PLAIN)) for key, value in leaves(summary)
            if key not in known and key.split(".")[0] not in HEAD_KEYS and not isinstance(value, list)]
