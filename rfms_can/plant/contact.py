"""Contact of tool and fixtures in MuJoCo: stiffness, damping, friction, and exact normals."""

from typing import Final

import mujoco

from rfms_can.plant.scene import EDGE_RADIUS, Contact

IMPEDANCE: Final = 0.5
"""MuJoCo's d: the fraction of a contact's acceleration that its constraint prescribes. With less,
spring and damper need shorter steps; near 1, MuJoCo's contact is rigid and ignores the spring."""
SLIDING_RATE: Final = 10.0
"""Rate at which friction reduces a sliding speed, 1/s, while the load is inside the friction cone.

MuJoCo's cone is convex: a body sliding at speed v is lifted as if its contact were softer, here by
friction SLIDING_RATE v / s0. With MuJoCo's default, the damping of the normal spring, a ball
pressed on with 20 N leaves the plate at 40 mm/s, and chatters."""
FRICTION_IMPEDANCE_RATIO: Final = 1e4
"""MuJoCo's impratio. A contact that sticks creeps there, by (1 - d) w / (impratio SLIDING_RATE):
0.7 micrometres a second under each newton."""
DISTANCE_TOLERANCE: Final = 1e-9
"""Of MuJoCo's distance of two shapes, m. The default of a micrometre corresponds to 10 N."""
SKIN: Final = EDGE_RADIUS
"""By how much MuJoCo's shapes are smaller than the solid ones, m.

Where two shapes overlap by less than its tolerance, MuJoCo 4 returns a wrong contact normal: with
the default tolerance for one in a hundred contacts of a leaning peg with a chamfer, by up to 117
degrees, and a peg wedged between two such faces meets large forces without a cause. For separate
shapes, distance and normal are exact, so a skin on each keeps them separate."""
CONTACT_DISTANCE: Final = 2.0 * SKIN
"""Distance of MuJoCo's shapes at which the solid surfaces touch, m."""


def set_options(spec: mujoco.MjSpec) -> None:
    """Solver options of contacts, of the whole model."""
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = FRICTION_IMPEDANCE_RATIO
    spec.option.ccd_tolerance = DISTANCE_TOLERANCE


def add_contact_pair(spec: mujoco.MjSpec, tool: str, fixture: str, contact: Contact) -> None:
    """Add an explicit contact pair: only there does MuJoCo let friction have its own solref."""
    spec.add_pair(
        geomname1=fixture,
        geomname2=tool,
        condim=3,
        margin=CONTACT_DISTANCE,
        friction=[contact.friction, contact.friction, 0.0, 0.0, 0.0],
        solimp=[IMPEDANCE, IMPEDANCE, 1e-3, 0.5, 2.0],
        solreffriction=[-1.0, -SLIDING_RATE],
    )


def set_stiffness(model: mujoco.MjModel, contact: Contact, tool: str) -> None:
    """Give every contact its stiffness and damping.

    MuJoCo's contact has a spring and a damper per unit of mass: with parameters s0 and s1 its force
    at rest is s0 depth / ((1 - d) w), where w is the tool's mean inverse mass at the angles 0.
    Solved for s0, the stiffness is that asked for, in N/m, wherever the arm stands.

    Args:
        model: of arm and scene.
        contact: between tool and fixtures.
        tool: name of the tool's body.
    """
    inverse_mass = float(model.body(tool).invweight0[0])  # of a translation, 1/kg
    spring = contact.stiffness * (1.0 - IMPEDANCE) * inverse_mass
    model.pair_solref[:] = -spring, -2.0 * contact.damping * spring**0.5
