"""Visibility of a surface in each pixel, for pictures and for the differentiable renderer."""
