"""Charts of pages as data, for page/charts.js: curves thinned to what a screen can show, in few digits.

A chart is a group with: title, note (what is seen), x and y ({title, log, min, max}), series ({label, colour, x, y, ...}), bands (shades
of the contact's modes), marks (lines across), group (charts with one cursor), size ("low", "high"), still (a PNG's name that tells the
same without Chart.js).
"""
import math

from report_parts.drawing import np

MOST_COLUMNS = 900  # of a curve: two values each
MODES = {"free": "no contact", "stick": "stick", "slide": "slide, no friction", "frictional_slide": "slide with friction"}


def short(value, digits=5):
    """JSON has no number that is not finite."""
    return float(f"{value:.{digits}g}") if math.isfinite(value) else None


def thinned(t, *curves):
    """Times and values with the least and the largest of each of at most MOST_COLUMNS stretches: no peak is lost."""
    if len(t) <= 2 * MOST_COLUMNS:
        return [short(v, 7) for v in t], [[short(v) for v in curve] for curve in curves]
    keep = {0, len(t) - 1}
    edges = np.linspace(0, len(t), MOST_COLUMNS // max(1, len(curves)) + 1).astype(int)
    for curve in curves:
        finite = np.where(np.isfinite(curve), curve, 0.0)
        for low, high in zip(edges[:-1], edges[1:]):
            keep.update((low + int(np.argmin(finite[low:high])), low + int(np.argmax(finite[low:high]))))
    chosen = sorted(keep)
    return [short(t[i], 7) for i in chosen], [[short(curve[i]) for i in chosen] for curve in curves]


def mode_bands(t, modes, most=400):
    """[until, {mode: share}] along time: modes that change faster than a screen can show become a mixture."""
    if len(t) < 2:
        return []
    changes = [i for i in range(1, len(modes)) if modes[i] != modes[i - 1]]
    if len(changes) < most:
        ends = changes + [len(modes)]
        return [[short(t[min(end, len(t) - 1)], 7), {str(modes[end - 1]): 1}] for end in ends]
    out, edges = [], np.linspace(0, len(t), most + 1).astype(int)
    for low, high in zip(edges[:-1], edges[1:]):
        words, counts = np.unique(modes[low:high], return_counts=True)
        out.append([short(t[high - 1], 7), {str(w): round(float(c) / (high - low), 3) for w, c in zip(words, counts)}])
    return out


def curve_chart(title, t, curves, y_title, **more):
    """Curves over one time. `curves`: (label, colour, values, more)."""
    x, ys = thinned(t, *(values for _, _, values, _ in curves))
    series = [{"label": label, "colour": colour, "y": y, **extra} for (label, colour, _, extra), y in zip(curves, ys)]
    return {"title": title, "x": {"title": "time [s]", "values": x, "min": short(t[0], 7), "max": short(t[-1], 7)}, "y": {"title": y_title}, "series": series, **more}


def histogram_chart(title, values, x_title, y_title, bins=25, **more):
    """How often each size occurs; in decades where they span more than one. Zeros are told, not shown, there."""
    positive = sorted(v for v in values if v > 0)
    zero = len(values) - len(positive)
    median = sorted(values)[len(values) // 2]
    told = f"{len(values)} {y_title}, median {median:.3g}" + (f"; {zero} are 0" if zero else "")
    if not positive:
        return {"title": title, "empty": f"0 in all {len(values)} {y_title}"}
    wide = positive[-1] > 10 * positive[0]
    scale, back = (math.log10, lambda v: 10**v) if wide else (lambda v: v, lambda v: v)
    low, high = scale(positive[0]), scale(positive[-1])
    if high <= low:
        low, high = low - 0.02 * max(1e-12, abs(low)) - 1e-12, high + 0.02 * max(1e-12, abs(high)) + 1e-12
    width = (high - low) / bins
    counts = [0] * bins
    for v in positive:
        counts[min(bins - 1, int((scale(v) - low) / width))] += 1
    # As steps: bars of a logarithmic axis have no even width.
    x, y = [], []
    for i, count in enumerate(counts):
        x += [short(back(low + i * width)), short(back(low + (i + 1) * width))]
        y += [count, count]
    return {"title": title, "note": told, "x": {"title": x_title, "log": wide, "min": short(back(low - 0.5 * width)), "max": short(back(high + 0.5 * width))}, "y": {"title": y_title, "min": 0, "whole": True},
            "series": [{"label": y_title, "colour": "grey", "x": x, "y": y, "fill": True}], "size": "low", **more}
