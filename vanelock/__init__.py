"""Friction-damped forced response of turbine stator vane segments.

The stages, each importing only those before it: `vanelock.mesh`, `vanelock.fem`, `vanelock.rom`,
`vanelock.nonlinear`, `vanelock.render`, `vanelock.report`, `vanelock.study`.
"""

__version__ = "0.1.0"
