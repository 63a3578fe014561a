"""Errors of reduced models, by residuals and by the unreduced sector."""
