"""Data inside a page."""
import json


def inline_json(value):
    """For <script type='application/json'>: no text in it can end the script, open a comment or begin another script."""
    text = json.dumps(value, ensure_ascii=False, separators=(",", ":"))
    for sign in "<>&\u2028\u2029":  # in JSON these stand in texts only
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return text
