"""Analyses of a case beyond its responses, one file each; the order is that of tables and page."""

from typing import Any

from vanelock.analyses.analysis import Analysis
from vanelock.analyses.bounds import BOUNDS
from vanelock.analyses.campbell import CAMPBELL
from vanelock.analyses.damped_modes import DAMPED_MODES
from vanelock.analyses.energy import ENERGY
from vanelock.analyses.energy_frequency import ENERGY_FREQUENCY
from vanelock.analyses.fatigue import FATIGUE
from vanelock.analyses.gauges import GAUGES
from vanelock.analyses.mistuning import MISTUNING
from vanelock.analyses.preload_by_cause import PRELOAD_BY_CAUSE
from vanelock.analyses.scatter import SCATTER
from vanelock.analyses.sensitivities import SENSITIVITIES
from vanelock.analyses.settled import SETTLED
from vanelock.analyses.stability import STABILITY
from vanelock.analyses.wear import WEAR

ANALYSES: tuple[Analysis[Any, Any], ...] = (
    SCATTER,
    SENSITIVITIES,
    PRELOAD_BY_CAUSE,
    BOUNDS,
    STABILITY,
    SETTLED,
    MISTUNING,
    DAMPED_MODES,
    ENERGY_FREQUENCY,
    WEAR,
    CAMPBELL,
    GAUGES,
    ENERGY,
    FATIGUE,
)
