"""Pictures of parts without a display: shading and figures."""
