"""A prepared part is tested: a surface goes in, the stress on it and a verdict come out."""
