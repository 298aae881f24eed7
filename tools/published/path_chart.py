# SPDX-License-Identifier: GPL-3.0-or-later
"""A path in space in the colours of a value, as SVG: the colours of the page of `nc`, two pictures side by side."""
import math
from html import escape

from published.chart import STYLE

COLOURS = [(43, 83, 178), (28, 137, 160), (64, 154, 92), (168, 160, 36), (222, 124, 30), (196, 40, 38)]
BINS, WIDTH, HEIGHT, TOP, BOTTOM = 24, 900, 430, 64, 48
AZIMUTH, ELEVATION = -0.6, 0.6


def colour(share):
    at = max(0.0, min(0.9999, share)) * (len(COLOURS) - 1)
    i = int(at)
    return "#" + "".join(f"{round(a + (at - i) * (b - a)):02x}" for a, b in zip(COLOURS[i], COLOURS[i + 1]))


def seen(place):
    """Parallel projection, x to the right and y up."""
    x, y, z = place
    ca, sa, ce, se = math.cos(AZIMUTH), math.sin(AZIMUTH), math.cos(ELEVATION), math.sin(ELEVATION)
    return ca * x + sa * y, ce * z + se * (ca * y - sa * x)


def picture(left, places, values, largest, name):
    """@param places  of points in space; None: the path is interrupted  @param values  of the segments' ends"""
    flat = [None if place is None else seen(place) for place in places]
    there = [point for point in flat if point is not None]
    low, high = ([f(p[i] for p in there) for i in (0, 1)] for f in (min, max))
    scale = min((WIDTH / 2 - 40) / ((high[0] - low[0]) or 1.0), (HEIGHT - TOP - BOTTOM) / ((high[1] - low[1]) or 1.0))
    middle = [(a + b) / 2 for a, b in zip(low, high)]

    def at(point):
        return (left + WIDTH / 4 + scale * (point[0] - middle[0]),
                (TOP + HEIGHT - BOTTOM) / 2 - scale * (point[1] - middle[1]))

    bins = [[] for _ in range(BINS)]
    for a, b, value in zip(flat, flat[1:], values[1:]):
        if a is not None and b is not None:
            bins[min(BINS - 1, int(value / largest * BINS))].append((at(a), at(b)))
    out = [f'<text x="{left + WIDTH / 4}" y="50" text-anchor="middle">{escape(name)}</text>']
    for i, segments in enumerate(bins):
        words, end = [], None
        for a, b in segments:
            begin, after = "{:.1f} {:.1f}".format(*a), "{:.1f} {:.1f}".format(*b)
            if begin == after:
                continue
            words.append(f"L{after}" if begin == end else f"M{begin}L{after}")
            end = after
        if words:
            out.append(f'<path fill="none" stroke="{colour((i + 0.5) / BINS)}" stroke-width="1.4" '
                       f'stroke-linecap="round" d="{"".join(words)}"/>')
    return "\n".join(out)


def write(path, title, unit, places, pictures):
    """@param pictures  (name, values), drawn from the left with one scale of colours"""
    largest = max(max(values) for _, values in pictures) or 1.0
    body = [picture(i * WIDTH / 2, places, values, largest, name) for i, (name, values) in enumerate(pictures)]
    left, wide, y = WIDTH / 2 - 120, 240, HEIGHT - 30
    bar = [f'<rect x="{left + wide * i / BINS:.1f}" y="{y}" width="{wide / BINS + 0.5:.1f}" height="12" '
           f'fill="{colour((i + 0.5) / BINS)}"/>' for i in range(BINS)]
    bar.append(f'<text x="{left - 8}" y="{y + 11}" text-anchor="end">0</text>'
               f'<text x="{left + wide + 8}" y="{y + 11}">{largest:.1f} {escape(unit)}</text>')
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" '
                    f'aria-label="{escape(title)}">\n<!-- SPDX-License-Identifier: GPL-3.0-or-later -->\n{STYLE}\n'
                    f'<text x="{WIDTH / 2}" y="24" text-anchor="middle">{escape(title)}</text>\n' +
                    "\n".join(body + bar) + "\n</svg>\n", encoding="utf-8")
