"""A response to an accuracy: harmonics and frequencies chosen by estimated errors."""
