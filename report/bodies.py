"""The skin of a mesh as a body of the 3-D view."""

import numpy as np
from numpy.typing import NDArray

from vanelock.mesh import Part
from vanelock.render.surface import surface
from vanelock.report.blocks import Body


def body_of(part: Part, corners_only: bool = True) -> tuple[Body, NDArray[np.int64]]:
    """Skin of a part through its elements' corners, and the part's nodes (m,) that it took.

    A shape of the part, (n, 3), becomes the body's by `shape[nodes]`. The sector's left and right
    faces stay in: the page leaves them out where it draws the full ring.
    """
    skin = surface(part, corners_only=corners_only)
    body = Body(part.points[skin.nodes], skin.triangles, part.sectors, skin.outline, part.name)
    return body, skin.nodes
