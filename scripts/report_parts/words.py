"""summary.json as tables of words and numbers."""
import html
import math


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


PLAIN = with_unit("")
ROWS = [  # (group, [(key in summary.json, name, how to write it, what it means)])
    ("Force on the tool", [
        ("force.mean_n", "normal force, mean", with_unit("N"), "pushes the tool out of the surface; over the steady drag"),
        ("force.max_n", "normal force, largest", with_unit("N"), ""),
        ("force.mean_t", "tangential force, mean", with_unit("N"), "resists the drag"),
        ("force.max_t", "tangential force, largest", with_unit("N"), ""),
        ("force.max_t_over_mu_n", "use of the friction cone", PLAIN, "largest tangential force over µ × normal force; Coulomb friction allows at most 1"),
        ("force.felt_t_over_mu_n", "… by the force that is felt", PLAIN, "the same of the force written to the device; the fade from one local model to the next may pass 1"),
        ("force.buzz", "buzz", percent, "vibration above 100 Hz over the mean force; people notice forces that differ by 7–10 %"),
        ("force.crossing_jump", "jump at a mesh line", percent, "largest change in one tick when the contact enters another triangle, over the mean force"),
        ("force.refresh_jump", "jump at a new local model", percent, "the same when the slow side delivers a new model"),
    ]),
    ("The mesh at the contact", [
        ("mesh_at_contact.cell_m", "cell of the surface under the tool", with_unit("mm", 1e3), "side of a square of two triangles"),
        ("mesh_at_contact.contact_radius_m", "radius of the contact", with_unit("mm", 1e3), "by Hertz, where the tool is deep"),
        ("mesh_at_contact.cell_over_contact_radius.mean", "cell over contact radius", PLAIN, "mean along the path; below 0.7 the mesh adds less than a quarter (4-node elements)"),
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
        ("penetration_max_m", "deepest penetration", with_unit("µm", 1e6), "of the tool below the deformed surface at the end of a tick"),
        ("energy_min_j", "least energy taken from the hand", with_unit("µJ", 1e6), "negative: the device was given energy"),
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
        ("local.certified_error", "certified error of the local model", percent, "against the full model, worst of 0–500 Hz"),
        ("local.expected_force_error", "error of the force to expect from it", percent, "at the rates of this run; people notice 7–10 %"),
        ("local.reason", "why this local model", PLAIN, ""),
    ]),
    ("The body's contacts with itself", [
        ("self_contact.contacts", "most pairs in contact", PLAIN, "vertex and triangle, or two edges, nearer than the reach"),
        ("self_contact.nearest_m", "nearest pair", with_unit("µm", 1e6), "never 0: the surface does not pass through itself"),
        ("self_contact.normal_n", "largest sum of normal forces", with_unit("N"), ""),
        ("self_contact.mean_normal_n", "… mean", with_unit("N"), "of all global steps"),
        ("self_contact.intersections", "triangles that cross", PLAIN, "after any global step; must be 0"),
    ]),
    ("Against the reference", [
        ("reference.force_error", "force error", percent, "over the whole run, against the full model with a fine step"),
        ("reference.jnd_fraction", "time with a noticeable error", percent, "share of the run in which the force is off by more than 10 %"),
    ]),
]
HEAD_KEYS = ("scene", "seed", "hash", "warnings", "notes", "trust", "real_time", "command", "settings", "contact")


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


def written(value, write):
    """A cell: empty for what was not measured; a word stays a word where a number was due."""
    if value is None or value == "":
        return "–"
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return html.escape(write(value) if is_number else figures(value))


def summary_table(runs):
    """One row a quantity, one column a run, with what it means. Keys that have no words yet come last, as they are."""
    many = len(runs) > 1
    head = "".join(f"<th class=number>{html.escape(run.name)}</th>" for run in runs) if many else "<th class=number>value</th>"
    out, known = [], set(HEAD_KEYS)
    for group, rows in ROWS:
        body = []
        for key, name, write, meaning in rows:
            known.add(key)
            values = [look_up(run.summary, key) for run in runs]
            if all(value in (None, "") for value in values):
                continue
            cells = "".join(f"<td class={'long' if isinstance(v, str) and len(v) > 16 else 'number'}>{written(v, write)}</td>" for v in values)
            body.append(f"<tr><td>{html.escape(name)}</td>{cells}<td class=note>{html.escape(meaning)}</td></tr>")
        if body:
            out.append(f"<h3>{group}</h3><table class=numbers><tr><th>quantity</th>{head}<th>meaning</th></tr>{''.join(body)}</table>")
    rest = [(key, value) for key, value in leaves(runs[0].summary)
            if key not in known and key.split(".")[0] not in HEAD_KEYS and not isinstance(value, list)]
    if rest:
        rows = "".join(f"<tr><td><code>{html.escape(key)}</code></td><td class=number>{written(value, PLAIN)}</td></tr>" for key, value in rest)
        out.append(f"<h3>Other numbers of summary.json</h3><table><tr><th>key</th><th class=number>value</th></tr>{rows}</table>")
    return "".join(out)
