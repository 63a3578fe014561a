"""From reduced coordinates back to displacement, strain and stress of every node."""
