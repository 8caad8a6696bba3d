"""The same drop on the CPU, vectorised over elements or over drops, and on CUDA."""
