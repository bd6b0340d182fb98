"""Plot of a teleoperation as SVG."""

WIDTH, HEIGHT, LEFT, TOP, SHOWN_S = 800, 130, 60, 24, 20.0


def line(points, colour, width):
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width}"/>'


def text(x, y, content, anchor="start"):
    return f'<text x="{x:.0f}" y="{y:.0f}" text-anchor="{anchor}">{content}</text>'


def plot(path, rows):
    """The first seconds of two joints and the gripper, of leader and follower."""
    # A third of the cycles: the file is in the documentation.
    rows = [row for row in rows if row[0] < SHOWN_S][::3]
    joints = [("shoulder_pan.pos", "deg", -75, 75), ("elbow_flex.pos", "deg", -75, 75), ("gripper.pos", "%", 0, 100)]
    svg = []
    for place, (joint, unit, low, high) in enumerate(joints):
        bottom = TOP + (place + 1) * HEIGHT - 10

        def point(time, value):
            return LEFT + time / SHOWN_S * (WIDTH - LEFT - 20), bottom - (value - low) / (high - low) * (HEIGHT - 30)

        for tick in (low, (low + high) / 2, high):
            (left, y), (right, _) = point(0, tick), point(SHOWN_S, tick)
            svg += [line([(left, y), (right, y)], "#c8ccd0", 1), text(left - 6, y + 4, f"{tick:g}", "end")]
        svg.append(text(LEFT, bottom - HEIGHT + 24, f"{joint.removesuffix('.pos')}, {unit}"))
        svg.append(line([point(now, action[joint]) for now, action, _ in rows], "#0969da", 3))
        svg.append(line([point(now, present[joint]) for now, _, present in rows], "#d1570a", 1.5))
    height = TOP + len(joints) * HEIGHT + 20
    svg += [text(LEFT + time / SHOWN_S * (WIDTH - LEFT - 20), height - 8, f"{time} s", "middle") for time in range(0, 21, 5)]
    svg += [f'<g fill="#0969da">{text(LEFT, 16, "leader")}</g>', f'<g fill="#d1570a">{text(LEFT + 70, 16, "follower")}</g>']
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}"'
    head += ' font-family="sans-serif" font-size="12" fill="#24292f"><rect width="100%" height="100%" fill="#ffffff"/>'
    path.write_text("\n".join([head, *svg, "</svg>", ""]), encoding="utf-8")
