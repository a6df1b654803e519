"""Small pictures of meshes from their outlines: drawn back to front, shaded, with the place of a failure ringed."""
import base64
import io

from report_parts.drawing import np

try:
    from PIL import Image, ImageDraw
except ImportError:  # comes with matplotlib
    Image = ImageDraw = None

# Looks down from the front left. Rows: right, up, towards the viewer.
VIEW = [[0.80, -0.60, 0.0], [0.28, 0.37, 0.886], [0.53, 0.71, -0.46]]
LIGHT = [0.35, 0.55, 0.76]  # in the picture's axes
BODY, MARK, PAPER = (120, 158, 190), (213, 60, 0), (255, 255, 255)
COLOURS = 20  # of a picture, besides the ring's


def projected(outline, width, height):
    """Corners of the triangles in pixels (k, 3, 2), their depth and brightness, and the map of any points."""
    x = np.array(outline["x"], float).reshape(-1, 3) / 255
    triangles = np.array(outline["t"], int).reshape(-1, 3)
    view = np.array(VIEW)
    view = view / np.linalg.norm(view, axis=1, keepdims=True)
    p = x @ view.T
    low, high = p[:, :2].min(axis=0), p[:, :2].max(axis=0)
    margin = 0.07 * min(width, height)
    scale = min((width - 2 * margin) / max(high[0] - low[0], 1e-9), (height - 2 * margin) / max(high[1] - low[1], 1e-9))
    middle = 0.5 * (low + high)

    def to_pixels(q):
        return np.stack([width / 2 + scale * (q[..., 0] - middle[0]), height / 2 - scale * (q[..., 1] - middle[1])], axis=-1)

    corners = p[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    light = np.array(LIGHT) / np.linalg.norm(LIGHT)
    brightness = 0.55 + 0.45 * np.abs(normals @ light)
    return to_pixels(corners), corners[:, :, 2].mean(axis=1), brightness, lambda q: to_pixels(np.asarray(q) @ view.T)


def ring(image, at, radius):
    """In colours of its own, so that few colours in all do not dull it."""
    image.putpalette(image.getpalette()[:3 * COLOURS] + list(PAPER) + list(MARK))
    draw = ImageDraw.Draw(image)
    for r, colour, width in ((radius + 1, COLOURS, 5), (radius, COLOURS + 1, 3)):
        draw.ellipse([at[0] - r, at[1] - r, at[0] + r, at[1] + r], outline=colour, width=width)


def thumbnail(outline, where, width, height):
    """A data: URI of a PNG; empty without an outline, or without PIL. `where`: in the file's coordinates, or None."""
    if Image is None or np is None or not outline or not outline.get("t"):
        return ""
    fine = 2  # drawn larger, then reduced: smooth edges
    corners, depth, brightness, to_pixels = projected(outline, fine * width, fine * height)
    image = Image.new("RGB", (fine * width, fine * height), PAPER)
    draw = ImageDraw.Draw(image)
    for k in np.argsort(depth, kind="stable"):
        shade = tuple(int(c * brightness[k]) for c in BODY)
        draw.polygon([tuple(c) for c in corners[k]], fill=shade)
    image = image.resize((width, height), Image.LANCZOS).quantize(COLOURS)
    if where is not None and all(isinstance(c, (int, float)) for c in where):
        at = to_pixels((np.array(where, float) - np.array(outline["min"], float)) / outline["size"]) / fine
        if np.isfinite(at).all():
            ring(image, at, max(5, 0.1 * min(width, height)))
    out = io.BytesIO()
    image.save(out, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(out.getvalue()).decode("ascii")
