"""Curves of histograms in a small SVG, as documentation shows them."""
import math

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#555555")
LEFT, TOP, BOTTOM, RIGHT = 46, 24, 30, 14
IN_A_ROW = 4  # Of the legend.


def shares(histogram):
    """Middles of the bins, and per cent of all in each."""
    counts, low = histogram["counts"], histogram["low"]
    width, whole = (histogram["high"] - low) / len(counts), sum(counts) or 1
    return [low + (i + 0.5) * width for i in range(len(counts))], [100 * c / whole for c in counts]


def steps(top):
    """Marks from 0 to `top`, of one significant digit apart."""
    unit = 10 ** math.floor(math.log10(top))
    step = next(f * unit for f in (0.2, 0.5, 1, 2) if top / (f * unit) <= 6)
    return [i * step for i in range(int(top / step) + 1)]


def panel(curves, low, high, left, top, width, height, title, logarithmic=False):
    """One plot of curves {name: histogram} between two values, in per cent, upright in even steps or in powers of ten."""
    drawn = {name: [(x, y) for x, y in zip(*shares(h)) if low <= x <= high] for name, h in curves.items()}
    most = max((y for points in drawn.values() for _, y in points), default=0) or 1
    floor = -5 if logarithmic else 0
    ceiling = math.ceil(math.log10(most)) if logarithmic else most * 1.05

    def px(x):
        return left + LEFT + (x - low) / (high - low) * (width - LEFT - RIGHT)

    def py(y):
        return top + height - BOTTOM - (y - floor) / (ceiling - floor) * (height - TOP - BOTTOM)

    marks = range(floor, ceiling + 1) if logarithmic else steps(ceiling)
    yield f'<text x="{left + LEFT}" y="{top + 15}" font-weight="bold">{title}</text>'
    for mark in marks:
        text = f"{10.0 ** mark:g}" if logarithmic else f"{mark:g}"
        yield f'<path d="M{px(low):.0f} {py(mark):.0f}H{px(high):.0f}" stroke="#ddd"/>'
        yield f'<text x="{left + LEFT - 4}" y="{py(mark) + 4:.0f}" text-anchor="end">{text}</text>'
    for i in range(5):
        x = low + (high - low) * i / 4
        yield f'<text x="{px(x):.0f}" y="{top + height - 12}" text-anchor="middle">{x:g}</text>'
    for colour, points in zip(COLOURS, drawn.values()):
        places = " ".join(f"{px(x):.0f},{py(math.log10(y) if logarithmic else y):.1f}" for x, y in points if y > 0 or not logarithmic)
        yield f'<polyline points="{places}" fill="none" stroke="{colour}" stroke-width="1.5"/>'


def figure(panels, names, width, height):
    """A whole file: panels as lists of lines, and a legend below."""
    whole = height + 20 * math.ceil(len(names) / IN_A_ROW) + 4
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {whole}" font-family="sans-serif" font-size="11">',
             '<rect width="100%" height="100%" fill="#fff"/>', *(line for lines in panels for line in lines)]
    for i, (colour, name) in enumerate(zip(COLOURS, names)):
        x, y = LEFT + i % IN_A_ROW * (width - LEFT) // IN_A_ROW, height + 8 + 20 * (i // IN_A_ROW)
        lines += [f'<path d="M{x} {y}h16" stroke="{colour}" stroke-width="3"/>', f'<text x="{x + 20}" y="{y + 4}">{name}</text>']
    return "\n".join([*lines, "</svg>", ""])


def angle_figure(curves):
    """All dihedral angles above the smallest and the largest ones, in per cent of each mesh's angles."""
    return figure([panel(curves, 0, 180, 0, 0, 760, 210, "dihedral angles, degrees; % of all"),
                   panel(curves, 0, 40, 0, 210, 380, 190, "0° to 40°"),
                   panel(curves, 140, 180, 380, 210, 380, 190, "140° to 180°")], curves, 760, 400)


def conformity_figure(ratios, lengths):
    """Mean ratios and lengths of edges in the metric, in even steps and in powers of ten."""
    return figure([panel(ratios, 0, 1, 0, 0, 380, 200, "mean ratio; % of tetrahedra"),
                   panel(ratios, 0, 1, 380, 0, 380, 200, "the same, powers of ten", True),
                   panel(lengths, 0, 2.8, 0, 200, 380, 200, "length of edges; % of edges"),
                   panel(lengths, 0, 2.8, 380, 200, 380, 200, "the same, powers of ten", True)], ratios, 760, 400)
