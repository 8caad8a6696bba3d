"""What each pixel of a picture sees of a surface, decided once for pictures and for the differentiable renderer."""
