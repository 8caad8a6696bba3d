"""Validation of the simulation against textbook solutions, conservation laws, CalculiX, finer meshes, other hardware."""
