"""Curves between two logarithmic axes, as SVG."""
from html import escape
from math import ceil, floor, log10

COLOURS = ["#009e73", "#d55e00", "#0072b2", "#cc79a7"]
LEFT, TOP, RIGHT, BOTTOM = 74, 34, 500, 348


def svg(title, across, up, curves):
    points = [p for _, curve in curves for p in curve]
    low = [log10(min(p[k] for p in points)) - 0.06 for k in (0, 1)]
    high = [log10(max(p[k] for p in points)) + 0.06 for k in (0, 1)]
    x = lambda v: LEFT + (RIGHT - LEFT) * (log10(v) - low[0]) / (high[0] - low[0])
    y = lambda v: BOTTOM - (BOTTOM - TOP) * (log10(v) - low[1]) / (high[1] - low[1])
    out = [
        '<svg xmlns="http://www.w3.org/2000/svg" width="800" height="400" viewBox="0 0 800 400" font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="#ffffff"/>',
        f'<text x="{LEFT}" y="20" font-size="14" font-weight="bold">{escape(title)}</text>',
    ]
    for k in (0, 1):
        for d in range(floor(low[k]), ceil(high[k]) + 1):
            if not low[k] <= d <= high[k]:
                continue
            text = f"{10.0**d:g}"
            if k == 0:
                out.append(f'<path d="M{x(10.0**d):.1f} {TOP}V{BOTTOM}" stroke="#e0e0e0"/><text x="{x(10.0**d):.1f}" y="{BOTTOM + 17}" text-anchor="middle">{text}</text>')
            else:
                out.append(f'<path d="M{LEFT} {y(10.0**d):.1f}H{RIGHT}" stroke="#e0e0e0"/><text x="{LEFT - 6}" y="{y(10.0**d) + 4:.1f}" text-anchor="end">{text}</text>')
    out.append(f'<rect x="{LEFT}" y="{TOP}" width="{RIGHT - LEFT}" height="{BOTTOM - TOP}" fill="none" stroke="#000000"/>')
    out.append(f'<text x="{(LEFT + RIGHT) / 2}" y="{BOTTOM + 36}" text-anchor="middle">{escape(across)}</text>')
    out.append(f'<text transform="translate(16 {(TOP + BOTTOM) / 2}) rotate(-90)" text-anchor="middle">{escape(up)}</text>')
    for i, (name, curve) in enumerate(curves):
        colour = COLOURS[i % len(COLOURS)]
        path = "L".join(f"{x(a):.1f} {y(b):.1f}" for a, b in curve)
        out.append(f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
        out += [f'<circle cx="{x(a):.1f}" cy="{y(b):.1f}" r="3.2" fill="{colour}"/>' for a, b in curve]
        out.append(f'<path d="M{RIGHT + 14} {TOP + 10 + 20 * i}h26" stroke="{colour}" stroke-width="2"/><text x="{RIGHT + 46}" y="{TOP + 14 + 20 * i}">{escape(name)}</text>')
    return "\n".join([*out, "</svg>", ""])
