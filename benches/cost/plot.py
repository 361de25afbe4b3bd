"""Draws the time of a slider step against the number of samples, from the saved outputs of `cargo bench --bench cost` and `beside.py`.

    python3 benches/cost/plot.py cost.txt beside.txt > assets/guide/cost.svg
"""

import math
import sys

WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 720, 400, 84, 24, 700, 340
ACROSS, UP = (4.9, 7.6), (0.5, 5.2)


def rows(path):
    lines = [line.split() for line in open(path, encoding="utf-8")]
    return [line for line in lines if line and line[0].isdigit()]


def place(samples, milliseconds):
    across = (math.log10(samples) - ACROSS[0]) / (ACROSS[1] - ACROSS[0])
    up = (math.log10(milliseconds) - UP[0]) / (UP[1] - UP[0])
    return LEFT + across * (RIGHT - LEFT), BOTTOM - up * (BOTTOM - TOP)


def words(x, y, text, anchor="middle", color="#333"):
    print(f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{color}">{text}</text>')


def line(points, color, label):
    places = [place(*point) for point in points]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    print(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="2"/>')
    for x, y in places:
        print(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.5" fill="{color}"/>')
    x, y = places[0]
    words(x + 14, y - 30, label, "start", color)


def main():
    own, beside = (rows(path) for path in sys.argv[1:3])
    print(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="14">')
    print(f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>')
    for power in range(5, 8):
        x, _ = place(10 ** power, 1e3)
        print(f'<path d="M{x:.1f} {TOP}V{BOTTOM}" stroke="#ccc"/>')
        words(x, BOTTOM + 20, f"{10 ** power:,}")
    for power in range(1, 6):
        _, y = place(1e6, 10 ** power)
        print(f'<path d="M{LEFT} {y:.1f}H{RIGHT}" stroke="#ccc"/>')
        words(LEFT - 8, y + 5, f"{10 ** power:,}", "end")
    words((LEFT + RIGHT) / 2, BOTTOM + 46, "samples")
    words(LEFT, TOP - 8, "a step of a slider [ms]")
    line([(int(row[0]), float(row[1])) for row in beside], "#b4541c", "NumPy, look-back in C")
    line([(int(row[0]), float(row[2])) for row in own], "#1f5fa8", "LoopScope")
    slope = [(10 ** power, 1e-4 * 10 ** power) for power in (5, 7.5)]
    places = [place(*point) for point in slope]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
    print(f'<polyline points="{path}" fill="none" stroke="#888" stroke-dasharray="5 4"/>')
    words(places[1][0], places[1][1] + 34, "100 ns a sample", "end", "#666")
    print("</svg>")


main()
