"""What the page on asked and achieved accuracy says around its tables."""

INTRODUCTION = """\
Scenes are drawn with a fixed seed (benchmarks/accuracy/scenes.py): thirteen designs of vane and
casing, five scenes each with their own joints, loads and damping. None was left out for being
hard. The mesh is pinned at 25 mm (most contacts act on nodes, which do not converge with the mesh),
so that errors are those of modes, harmonics, samples and frequencies. The peak is the largest
amplitude of the monitored output, the study's default, over its default range.

References (benchmarks/accuracy/references.py): the response of a finer reduced model is swept with
five harmonics, upwards and downwards; each high maximum is then located exactly
with 5, 9, 14, 20, 27, 38, 53 harmonics until its amplitude changes by less than 1e-4 (in the last
table, doubt: the last change; the largest is {doubt:.0e}). A scene is judged where its doubt is
below {sure:g} of the accuracy. {missing} Runs of more than a quarter of an hour are broken off.
The error of a run is the larger of the relative errors of the peak's amplitude and frequency. Where
the curve jumps, a second branch may reach higher: {higher}. A run that finds the higher one is
judged by it.

Costs are CPU times, one thread, of reducing the parts and of the response; meshing and assembly,
the same in all, are left out. The unit is the mean of the default setting, `rom.accuracy` 1e-4 and
three harmonics: {unit:.1f} s.

![Errors](accuracy_errors.png)

![Costs](accuracy_costs.png)
"""
ASKED = """\
"Not 30 times below": within the accuracy, but by no more than that factor, beyond which an error
is not worth its cost. Median, 95 % below and worst are of the larger error of both."""
SIZES = "Means over the scenes. Coordinates: of the reduced model. Harmonics are chosen by point."
FIXED = """\
Settings given for all scenes alike; points as a range takes them by default, swept upwards. No
number of harmonics makes that safe: in scene 28 the largest response is on a branch that a sweep
upwards does not meet, in scene 21 a peak lies between two points. The range split in four, each
part swept upwards and downwards, finds both. A fixed setting reduces the casing at the nodal
diameters that its harmonics have, each at an equal share of the time that all of them took. Below:
the cheapest of these settings that is safe in the scenes that it was run in, and the time by
accuracy over its time in the same scenes."""
ESTIMATES = "The run's own estimate of the error of the peak's amplitude against the true one."
BEYOND = """\
Scenes where one of the errors exceeds the accuracy asked for. In scenes 4 and 21 the runs at 0.001
find what the references miss, a higher peak of another branch: 4.264 µm at 287.35 Hz, not 4.247 at
301.76, and 1.104 µm at 279.64 Hz, not 0.738 at 309.14."""
SCENES = """\
μ and interference are the interlock's, or the hooks' where it is left out. Slip, open: the
largest share of a joint's contacts at the peak. Last columns: the error by accuracy asked for."""
