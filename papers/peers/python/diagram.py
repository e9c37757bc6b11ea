"""The work-precision diagram as SVG: error over seconds, both logarithmic."""

import math
from html import escape

from comparison import TARGET_ERROR

WIDTH, HEIGHT = 980, 560
LEFT, RIGHT, TOP, BOTTOM = 78, 296, 40, 64
# Okabe and Ito's colours, distinguished by everybody; a peer has one, its methods differ by dashes and marks.
COLORS = {"Erard": "#000000", "Erard batch": "#707070", "diffsol": "#0072b2", "MuJoCo": "#d55e00", "SciPy": "#009e73"}
DASHES = ["", "7 3", "2 3", "9 3 2 3"]
FONT = "DejaVu Sans, Verdana, sans-serif"


def decades(values):
    low, high = math.log10(min(values)), math.log10(max(values))
    return math.floor(low - 0.05), math.ceil(high + 0.05)


def svg(comparison, title):
    """The diagram. Lines join the settings that no other one of the same method beats; the rest are the faint dots."""
    drawn = [(peer, comparison.front(peer), comparison.of(peer)) for peer in comparison.names()]
    drawn = [entry for entry in drawn if entry[1]]
    points = [point for _, _, all_points in drawn for point in all_points]
    x_low, x_high = decades([p["seconds"] for p in points] + [comparison.until_s])
    y_low, y_high = decades([min(p["error"], 0.1) for p in points])
    x = lambda value: LEFT + (math.log10(value) - x_low) / (x_high - x_low) * (WIDTH - LEFT - RIGHT)
    y = lambda value: HEIGHT - BOTTOM - (math.log10(value) - y_low) / (y_high - y_low) * (HEIGHT - TOP - BOTTOM)
    text = lambda px, py, words, more="": f'<text x="{px:.1f}" y="{py:.1f}" {more}>{escape(words)}</text>'
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
        f'font-family="{FONT}" font-size="13" fill="#222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
        text(LEFT, 22, title, 'font-size="15"'),
    ]
    edge, floor = WIDTH - RIGHT, HEIGHT - BOTTOM
    for k in range(x_low, x_high + 1):
        at = x(10.0**k)
        out.append(f'<line x1="{at:.1f}" y1="{TOP}" x2="{at:.1f}" y2="{floor}" stroke="#ddd"/>')
        out.append(text(at, floor + 18, duration(10.0**k), 'text-anchor="middle"'))
    for k in range(y_low, y_high + 1):
        at = y(10.0**k)
        out.append(f'<line x1="{LEFT}" y1="{at:.1f}" x2="{edge}" y2="{at:.1f}" stroke="#ddd"/>')
        out.append(text(LEFT - 8, at + 4, f"1e{k}", 'text-anchor="end"'))
    out.append(text((LEFT + edge) / 2, floor + 42, "time for one blow, on one core where nothing else is said", 'text-anchor="middle"'))
    out.append(
        text(
            0,
            0,
            "hammer speed: relative error, rms of all blows",
            f'text-anchor="middle" transform="translate(20 {(TOP + floor) / 2:.0f}) rotate(-90)"',
        )
    )
    real = x(comparison.until_s)
    out.append(f'<line x1="{real:.1f}" y1="{TOP}" x2="{real:.1f}" y2="{floor}" stroke="#888" stroke-dasharray="4 4"/>')
    out.append(text(real - 6, TOP + 16, "real time", 'text-anchor="end" fill="#555"'))
    equal = y(TARGET_ERROR)
    out.append(f'<line x1="{LEFT}" y1="{equal:.1f}" x2="{edge}" y2="{equal:.1f}" stroke="#888" stroke-dasharray="4 4"/>')
    methods = {}
    for place, (peer, front, all_points) in enumerate(drawn):
        family = front[0]["peer"] + (" batch" if "batch_cores" in front[0] else "")
        rank = methods[family] = methods.get(family, -1) + 1
        color, dash = COLORS.get(family, "#555"), DASHES[rank % len(DASHES)]
        for p in all_points:
            if p["error"] <= 10.0**y_high:
                out.append(
                    f'<circle cx="{x(p["seconds"]):.1f}" cy="{y(p["error"]):.1f}" r="2" fill="{color}" fill-opacity="0.25"/>'
                )
        shown = [p for p in front if p["error"] <= 10.0**y_high]
        path = " ".join(f"{x(p['seconds']):.1f},{y(p['error']):.1f}" for p in shown)
        thick = 3 if front[0]["peer"] == "Erard" else 1.8
        stroke = f'stroke="{color}" stroke-width="{thick}"' + (f' stroke-dasharray="{dash}"' if dash else "")
        out.append(f'<polyline points="{path}" fill="none" {stroke} stroke-linejoin="round"/>')
        out += [mark(rank, x(p["seconds"]), y(p["error"]), color) for p in shown]
        row = TOP + 12 + 24 * place
        out.append(f'<line x1="{edge + 16}" y1="{row}" x2="{edge + 50}" y2="{row}" {stroke}/>')
        out.append(mark(rank, edge + 33, row, color))
        out.append(text(edge + 58, row + 4, peer, f'fill="{color}" font-size="12"'))
    out.append(f'<rect x="{LEFT}" y="{TOP}" width="{edge - LEFT}" height="{floor - TOP}" fill="none" stroke="#444"/>')
    return "\n".join([*out, "</svg>", ""])


def duration(value):
    for unit, name in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if value >= unit * 0.999:
            return f"{value / unit:.0f} {name}"
    return f"{value:.0e} s"


def mark(rank, px, py, color):
    """Disc, square, triangle, diamond."""
    shapes = [
        f'<circle cx="{px:.1f}" cy="{py:.1f}" r="4"',
        f'<rect x="{px - 3.5:.1f}" y="{py - 3.5:.1f}" width="7" height="7"',
        f'<polygon points="{px:.1f},{py - 5:.1f} {px + 4.5:.1f},{py + 3.5:.1f} {px - 4.5:.1f},{py + 3.5:.1f}"',
        f'<polygon points="{px:.1f},{py - 5:.1f} {px + 5:.1f},{py:.1f} {px:.1f},{py + 5:.1f} {px - 5:.1f},{py:.1f}"',
    ]
    return f'{shapes[rank % len(shapes)]} fill="{color}"/>'
