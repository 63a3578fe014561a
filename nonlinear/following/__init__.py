"""What follows a response along force, friction or interference, through peaks and hysteresis."""
