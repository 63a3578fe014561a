"""The smallest study that has all of it: 22 contacts and the largest elements."""

SMALL = """
vane.root_fillet = 0
vane.interlock_nodes = 3
vane.hook.band_nodes = 5
mesh.size = "40 mm"
joints.hook.kn = 5e7
joints.hook.kt = 5e7
joints.interlock.kn = 1.67e6
joints.interlock.kt = 1.67e6
"""
"""Keys of a study, before its tables; joints are as stiff as by default as a whole."""
HOOK, INTERLOCK = 16, 6
"""Its contacts, in this order."""
