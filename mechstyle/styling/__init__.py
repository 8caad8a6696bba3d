"""From a prompt to a relief and colours on the surface."""
