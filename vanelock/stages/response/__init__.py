"""Steps to linear limits, preload and responses of the joined system."""
