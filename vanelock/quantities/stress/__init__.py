"""Stress cycles and the fatigue that they mean, place by place."""
