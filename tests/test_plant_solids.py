"""Parts of a tool: mass and inertia are the integrals over the shape."""

import numpy as np
import pytest
from numpy.typing import NDArray

from rfms_can.plant.scene import Kind
from rfms_can.plant.scene.solids import STEEL_DENSITY, Part
from rfms_can.transform import Vector3

STEPS = 120


def inside(kind: Kind, size: Vector3, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    a, b, c = size
    x, y, z = points
    found: dict[Kind, NDArray[np.bool_]] = {
        Kind.BOX: (abs(x) <= a) & (abs(y) <= b) & (abs(z) <= c),
        Kind.CYLINDER: (x**2 + y**2 <= a**2) & (abs(z) <= b),
        Kind.SPHERE: x**2 + y**2 + z**2 <= a**2,
    }
    return found[kind]


@pytest.mark.parametrize(
    ("kind", "size"),
    [
        (Kind.BOX, (0.010, 0.020, 0.030)),
        (Kind.CYLINDER, (0.010, 0.025, 0.0)),
        (Kind.SPHERE, (0.020, 0.0, 0.0)),
    ],
)
def test_mass_and_inertia_are_integrals_over_the_shape(kind: Kind, size: Vector3) -> None:
    reach = max(size)
    axis = (np.arange(STEPS) + 0.5) / STEPS * 2.0 * reach - reach
    points = np.array(np.meshgrid(axis, axis, axis)).reshape(3, -1)
    x2, y2, z2 = points[:, inside(kind, size, points)] ** 2
    cell = STEEL_DENSITY * (axis[1] - axis[0]) ** 3
    part = Part(kind, size, 0.0)
    assert part.mass == pytest.approx(cell * len(x2), rel=0.02)
    moments = [cell * float(np.sum(each)) for each in (y2 + z2, x2 + z2, x2 + y2)]
    assert part.inertia == pytest.approx(moments, rel=0.02)


def test_a_plane_is_no_part_of_a_tool() -> None:
    """It is infinite: asked for its mass, the table says so at once."""
    with pytest.raises(KeyError):
        _ = Part(Kind.PLANE, (1.0, 1.0, 0.0), 0.0).mass
