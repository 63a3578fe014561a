"""A response to an accuracy: harmonics, samples and frequencies chosen by estimated errors."""
