# SPDX-License-Identifier: GPL-3.0-or-later
"""Line charts as SVG, one panel below the other: the same frame and inks as core/line_chart.h, for scripts."""
import math
from html import escape

INKS = ["#1f6fb4", "#d1651b", "#2b8a3e", "#8a4fbf", "#b5373c", "#6d6d6d"]
STYLE = ("<style>text{font:13px sans-serif;fill:#333}.frame{fill:none;stroke:#999}.grid{stroke:#999;stroke-opacity:.25}"
         "@media(prefers-color-scheme:dark){text{fill:#ddd}}</style>")
WIDTH, LEFT, RIGHT, TOP, PANEL, GAP = 760, 78, 170, 44, 220, 62


def ticks(low, high, most=6):
    """Round numbers from low to high."""
    span = (high - low) or 1.0
    step = 10.0 ** math.floor(math.log10(span / most))
    step *= next(f for f in (1, 2, 5, 10) if span / (f * step) <= most)
    return [i * step for i in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


def panel(top, name, unit_x, unit_y, lines):
    """@param lines  (name, [(x, y)]) @raises ValueError without a finite point"""
    points = [p for _, own in lines for p in own if math.isfinite(p[0]) and math.isfinite(p[1])]
    if not points:
        raise ValueError(f"{name}: no finite point to draw")
    low_x, high_x = min(p[0] for p in points), max(p[0] for p in points)
    low_y, high_y = min(p[1] for p in points), max(p[1] for p in points)
    margin = 0.05 * ((high_y - low_y) or 1.0)
    low_y, high_y, right, bottom = low_y - margin, high_y + margin, WIDTH - RIGHT, top + PANEL

    def at(p):
        return (LEFT + (p[0] - low_x) / ((high_x - low_x) or 1.0) * (right - LEFT),
                bottom - (p[1] - low_y) / (high_y - low_y) * PANEL)

    out = [f'<text x="{LEFT}" y="{top - 8}">{escape(name)}</text>',
           f'<rect class="frame" x="{LEFT}" y="{top}" width="{right - LEFT}" height="{PANEL}"/>']
    for x in ticks(low_x, high_x):
        px = at((x, low_y))[0]
        out.append(f'<line class="grid" x1="{px:.1f}" x2="{px:.1f}" y1="{top}" y2="{bottom}"/>'
                   f'<text x="{px:.1f}" y="{bottom + 16}" text-anchor="middle">{x:g}</text>')
    for y in ticks(low_y, high_y):
        py = at((low_x, y))[1]
        out.append(f'<line class="grid" x1="{LEFT}" x2="{right}" y1="{py:.1f}" y2="{py:.1f}"/>'
                   f'<text x="{LEFT - 6}" y="{py + 4:.1f}" text-anchor="end">{y:g}</text>')
    middle = top + PANEL / 2
    out.append(f'<text x="{(LEFT + right) / 2}" y="{bottom + 34}" text-anchor="middle">{escape(unit_x)}</text>'
               f'<text x="18" y="{middle}" text-anchor="middle" transform="rotate(-90 18 {middle})">'
               f'{escape(unit_y)}</text>')
    for i, (line, own) in enumerate(lines):
        ink, run, runs = INKS[i % len(INKS)], [], []
        for p in own:
            if math.isfinite(p[0]) and math.isfinite(p[1]):
                run.append("{:.1f},{:.1f}".format(*at(p)))
            elif run:
                runs, run = runs + [run], []
        for part in runs + [run]:
            out.append(f'<polyline fill="none" stroke="{ink}" stroke-width="1.6" points="{" ".join(part)}"/>')
        out.append(f'<line x1="{right + 10}" x2="{right + 30}" y1="{top + 14 + 20 * i}" y2="{top + 14 + 20 * i}" '
                   f'stroke="{ink}" stroke-width="2"/><text x="{right + 36}" y="{top + 18 + 20 * i}">'
                   f'{escape(line)}</text>')
    return "\n".join(out)


def write(path, title, panels, unit_x, unit_y):
    """@param panels  (name, [(line, [(x, y)])]), drawn from the top"""
    height = TOP + len(panels) * (PANEL + GAP)
    body = [panel(TOP + 14 + i * (PANEL + GAP), name, unit_x, unit_y, lines) for i, (name, lines) in enumerate(panels)]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" '
                    f'aria-label="{escape(title)}">\n<!-- SPDX-License-Identifier: GPL-3.0-or-later -->\n{STYLE}\n'
                    f'<text x="{LEFT}" y="26">{escape(title)}</text>\n' + "\n".join(body) + "\n</svg>\n")


BAR, BETWEEN = 14, 26   # width of a bar, between two groups
BARS_TOP, BARS = 44, 240


def key_of_bars(labels, left):
    return [f'<rect x="{left}" y="{BARS_TOP + 6 + 20 * i}" width="12" height="12" fill="{INKS[i % len(INKS)]}"/>'
            f'<text x="{left + 18}" y="{BARS_TOP + 17 + 20 * i}">{escape(label)}</text>'
            for i, label in enumerate(labels)]


def write_bars(path, title, groups, unit):
    """@param groups  (name, [(label, value)]), the same labels in each: bars beside each other, one axis. A value is a
    number, the two ends of a range, or None
    """
    labels = [label for label, _ in groups[0][1]]
    ends = {(g, i): value if isinstance(value, tuple) else (0.0, value) for g, (_, own) in enumerate(groups)
            for i, (_, value) in enumerate(own) if value is not None}
    values = [end for pair in ends.values() for end in pair]
    low, high = min(0.0, *values) if values else 0.0, max(values, default=1.0)
    high = high if high > low else low + 1.0
    step = len(labels) * BAR + BETWEEN
    right, bottom = LEFT + len(groups) * step + BETWEEN, BARS_TOP + BARS
    turned = max(len(name) for name, _ in groups) * 6.5 > step   # names that do not fit beside each other
    below = 40 + 3.3 * max(len(name) for name, _ in groups) if turned else 40
    # A turned name ends below its group and may begin left of the axis.
    starts = [LEFT + (g + 0.5) * step - 6.0 * len(name) for g, (name, _) in enumerate(groups)]
    begin = min(0.0, *starts) if turned else 0.0
    width = max(right + RIGHT - begin, WIDTH)

    def y(value):
        return bottom - (value - low) / (1.05 * (high - low)) * BARS

    out = [f'<rect class="frame" x="{LEFT}" y="{BARS_TOP}" width="{right - LEFT}" height="{BARS}"/>']
    for tick in ticks(low, high):
        out.append(f'<line class="grid" x1="{LEFT}" x2="{right}" y1="{y(tick):.1f}" y2="{y(tick):.1f}"/>'
                   f'<text x="{LEFT - 6}" y="{y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>')
    for g, (name, own) in enumerate(groups):
        left = LEFT + BETWEEN + g * step
        middle = left + len(labels) * BAR / 2
        turn = f' transform="rotate(-30 {middle} {bottom + 16})"' if turned else ""
        out.append(f'<text x="{middle}" y="{bottom + 16}" text-anchor="{"end" if turned else "middle"}"{turn}>'
                   f'{escape(name)}</text>')
        for i, (_, value) in enumerate(own):
            if value is None:
                continue
            top, foot = sorted(y(end) for end in ends[g, i])
            words = " to ".join(f"{end:.3g}" for end in value) if isinstance(value, tuple) else f"{value:.3g}"
            out.append(f'<rect x="{left + i * BAR}" y="{top:.1f}" width="{BAR - 2}" height="{foot - top:.1f}" '
                       f'fill="{INKS[i % len(INKS)]}"><title>{words}</title></rect>')
    out += key_of_bars(labels, right + 10)
    out.append(f'<text x="18" y="{(BARS_TOP + bottom) / 2}" text-anchor="middle" '
               f'transform="rotate(-90 18 {(BARS_TOP + bottom) / 2})">{escape(unit)}</text>')
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{begin:.0f} 0 {width:.0f} {bottom + below:.0f}" '
                    f'role="img" aria-label="{escape(title)}">\n<!-- SPDX-License-Identifier: GPL-3.0-or-later -->\n'
                    f'{STYLE}\n<text x="{LEFT}" y="26">{escape(title)}</text>\n' + "\n".join(out) + "\n</svg>\n")
