"""Styles that are learned: CLIP, the X-Mesh style field and the renderer between them. Only this room imports torch."""
