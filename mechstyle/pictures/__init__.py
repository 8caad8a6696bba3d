"""Pictures of parts without a display: rasteriser, shading and figures."""
