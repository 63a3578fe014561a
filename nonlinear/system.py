"""The solver's input, re-exported from where it is defined."""

from vanelock.rom.system import Contacts, Diameter, Force, System

__all__ = ["Contacts", "Diameter", "Force", "System"]
