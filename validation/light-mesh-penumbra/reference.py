"""A panel of 1 m x 1 m, 3 m above the floor, behind a board at 1.5 m that ends at x = 0: what is seen of it is a rectangle."""
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from lambert import configuration_factor, write, write_points  # noqa: E402

EXITANCE, PANEL_M, BOARD_M = 1000.0, 3.0, 1.5


def illuminance(x):
    # The ray over the board's edge meets the panel's plane here; what lies at smaller x is hidden.
    edge = x * (1 - PANEL_M / BOARD_M)
    low = max(-0.5, edge)
    if low >= 0.5:
        return 0.0
    corners = [(low, -0.5, PANEL_M), (0.5, -0.5, PANEL_M), (0.5, 0.5, PANEL_M), (low, 0.5, PANEL_M)]
    return EXITANCE * configuration_factor((x, 0.013, 0.0), (0, 0, 1), corners)


places = [round(-1.5 + 0.05 * number + 0.007, 6) for number in range(61)]
write(HERE, ["x", "exact"], [[x, illuminance(x)] for x in places])
write_points(HERE, "points.csv", [((x, 0.013, 0.0), (0, 0, 1)) for x in places])
