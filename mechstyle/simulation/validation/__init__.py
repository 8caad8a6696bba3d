"""What the simulation is held against: textbook solutions, conservation laws, CalculiX, finer meshes, other hardware."""
