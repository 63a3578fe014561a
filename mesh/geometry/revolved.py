"""Outlines of the revolved bodies: casing, outer shroud with its hooks, inner shroud."""

from vanelock.mesh.geometry.dimensions import CasingDimensions, HookDimensions, VaneDimensions
from vanelock.mesh.geometry.outline import Corner


def casing_outline(casing: CasingDimensions, hook: HookDimensions) -> list[Corner]:
    """Around the section: along the outside, then back along the inside."""
    outside = [
        Corner(casing.flange_radius, 0.0),
        Corner(casing.flange_radius, casing.flange_thickness),
        Corner(casing.outer_radius, casing.flange_thickness),
        Corner(casing.outer_radius, casing.length - casing.flange_thickness),
        Corner(casing.flange_radius, casing.length - casing.flange_thickness),
        Corner(casing.flange_radius, casing.length),
    ]
    front = [
        Corner(casing.inner_radius, casing.rail_front, casing.fillet),
        Corner(casing.rail_inner_radius, casing.rail_front),
        Corner(casing.rail_inner_radius, casing.groove_mouth),
        Corner(hook.lip_radius, casing.groove_mouth),
        Corner(hook.lip_radius, casing.groove_bottom, casing.fillet),
        Corner(hook.roof_radius, casing.groove_bottom, casing.fillet),
        Corner(hook.roof_radius, casing.groove_mouth),
        Corner(casing.inner_radius, casing.groove_mouth, casing.fillet),
    ]
    rear = [corner._replace(z=2 * hook.mid_plane - corner.z) for corner in front]
    ends = [Corner(casing.inner_radius, casing.length), Corner(casing.inner_radius, 0.0)]
    return [*outside, ends[0], *rear, *reversed(front), ends[1]]


def hooks_outline(vane: VaneDimensions) -> list[Corner]:
    """Around the section of the outer shroud with both hooks, beginning at the front hook."""
    hook = vane.hook
    front = [
        Corner(vane.outer_shroud_outer_radius, vane.leg_rear, vane.fillet),
        Corner(hook.roof_radius, vane.leg_rear),
        Corner(hook.roof_radius, vane.foot_front),
        Corner(hook.lip_radius, vane.foot_front),
        Corner(hook.lip_radius, vane.leg_front, vane.fillet),
        Corner(vane.outer_shroud_outer_radius, vane.leg_front, vane.fillet),
        Corner(vane.outer_shroud_outer_radius, vane.outer_shroud_front),
        Corner(vane.outer_shroud_inner_radius, vane.outer_shroud_front),
    ]
    rear = [corner._replace(z=2 * hook.mid_plane - corner.z) for corner in reversed(front)]
    return front + rear


def inner_shroud_outline(vane: VaneDimensions) -> list[Corner]:
    """Around the section of the inner shroud."""
    inner, outer = vane.inner_shroud_inner_radius, vane.inner_shroud_outer_radius
    front = vane.inner_shroud_front
    rear = 2 * vane.hook.mid_plane - front
    return [Corner(inner, front), Corner(inner, rear), Corner(outer, rear), Corner(outer, front)]
