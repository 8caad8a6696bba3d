"""Reading, repairing, meshing and measuring the shape of a part."""
