"""The part in 3D: scene, shaders, layers, legend, probe, and the impact moment by moment."""
