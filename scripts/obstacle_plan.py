"""The obstacle of a case seen from above, for all pictures."""
import math


def obstacle_plan(obstacle):
    """Corners (x, y), m, counter-clockwise from above, of the obstacle of a resolved case; its most upstream point is at x = 0."""
    width, shape = obstacle["width_m"], obstacle.get("shape", "box")
    if shape == "cylinder":
        angles = (2.0 * math.pi * i / 64 for i in range(64))
        return [(0.5 * width * (1.0 + math.cos(a)), 0.5 * width * math.sin(a)) for a in angles]
    depth = obstacle["depth_m"]
    if shape == "wedge":
        return [(0.0, 0.0), (depth, -0.5 * width), (depth, 0.5 * width)]
    turn = math.radians(obstacle.get("rotation_deg", 0.0))
    corners = [(-depth, -width), (depth, -width), (depth, width), (-depth, width)]
    turned = [(0.5 * (x * math.cos(turn) - y * math.sin(turn)), 0.5 * (x * math.sin(turn) + y * math.cos(turn))) for x, y in corners]
    front = min(x for x, _ in turned)
    return [(x - front, y) for x, y in turned]
