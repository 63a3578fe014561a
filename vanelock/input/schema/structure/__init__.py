"""Tables of the study file on the structure, its temperature and its loads at rest."""
