"""Curves between two logarithmic axes, one panel below the other, as SVG."""
from dataclasses import dataclass
from html import escape
from math import ceil, floor, log10

COLOURS = ["#009e73", "#d55e00", "#0072b2", "#cc79a7"]
LEFT, TOP, RIGHT, BOTTOM = 74, 34, 500, 348
WIDTH, HEIGHT = 800, 400


@dataclass
class Panel:
    """Curves of (seconds, error) by name, and of the times to reach an error: name, error, ratio, whether it is marked."""

    title: str
    across: str
    up: str
    curves: list
    notes: list


def svg(panels, levels):
    """All panels, with dashed lines at the errors that are compared."""
    size = f'width="{WIDTH}" height="{HEIGHT * len(panels)}" viewBox="0 0 {WIDTH} {HEIGHT * len(panels)}"'
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="#ffffff"/>',
    ]
    for i, panel in enumerate(panels):
        out += [f'<g transform="translate(0 {HEIGHT * i})">', *draw(panel, levels), "</g>"]
    return "\n".join([*out, "</svg>", ""])


def draw(panel, levels):
    curves = [(name, [(t, 100 * e) for t, e in curve]) for name, curve in panel.curves]
    points = [p for _, curve in curves for p in curve]
    low = [log10(min(p[k] for p in points)) - 0.06 for k in (0, 1)]
    high = [log10(max(p[k] for p in points)) + 0.06 for k in (0, 1)]
    x = lambda v: LEFT + (RIGHT - LEFT) * (log10(v) - low[0]) / (high[0] - low[0])
    y = lambda v: BOTTOM - (BOTTOM - TOP) * (log10(v) - low[1]) / (high[1] - low[1])
    out = [f'<text x="{LEFT}" y="20" font-size="14" font-weight="bold">{escape(panel.title)}</text>']
    for k in (0, 1):
        for d in range(floor(low[k]), ceil(high[k]) + 1):
            if not low[k] <= d <= high[k]:
                continue
            text = f"{10.0**d:g}"
            if k == 0:
                out.append(f'<path d="M{x(10.0**d):.1f} {TOP}V{BOTTOM}" stroke="#e0e0e0"/><text x="{x(10.0**d):.1f}" y="{BOTTOM + 17}" text-anchor="middle">{text}</text>')
            else:
                out.append(f'<path d="M{LEFT} {y(10.0**d):.1f}H{RIGHT}" stroke="#e0e0e0"/><text x="{LEFT - 6}" y="{y(10.0**d) + 4:.1f}" text-anchor="end">{text}</text>')
    for level in levels:
        if low[1] < log10(100 * level) < high[1]:
            out.append(f'<path d="M{LEFT} {y(100 * level):.1f}H{RIGHT}" stroke="#888888" stroke-dasharray="3 3"/>')
    out.append(f'<rect x="{LEFT}" y="{TOP}" width="{RIGHT - LEFT}" height="{BOTTOM - TOP}" fill="none" stroke="#000000"/>')
    out.append(f'<text x="{(LEFT + RIGHT) / 2}" y="{BOTTOM + 36}" text-anchor="middle">{escape(panel.across)}</text>')
    out.append(f'<text transform="translate(16 {(TOP + BOTTOM) / 2}) rotate(-90)" text-anchor="middle">{escape(panel.up)}</text>')
    below = TOP + 14
    for i, (name, curve) in enumerate(curves):
        colour = COLOURS[i % len(COLOURS)]
        path = "L".join(f"{x(a):.1f} {y(b):.1f}" for a, b in curve)
        out.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        out += [f'<circle cx="{x(a):.1f}" cy="{y(b):.1f}" r="3.2" fill="{colour}"/>' for a, b in curve]
        out.append(f'<path d="M{RIGHT + 14} {below - 4}h26" stroke="{colour}" stroke-width="2"/><text x="{RIGHT + 46}" y="{below}">{escape(name)}</text>')
        below += 17
        for _, error, ratio, is_marked in (n for n in panel.notes if n[0] == name):
            out.append(f'<text x="{RIGHT + 46}" y="{below}" fill="#444444">CPU time to {100 * error:g} %: {ratio}{" *" * is_marked}</text>')
            below += 16
        below += 6
    if panel.notes:
        out.append(f'<text x="{RIGHT + 14}" y="{below}" fill="#444444">×: over umbrage\'s; –: not reached</text>')
        if any(n[3] for n in panel.notes):
            out.append(f'<text x="{RIGHT + 14}" y="{below + 16}" fill="#444444">*: beyond the runs, see ratios.csv</text>')
    return out
