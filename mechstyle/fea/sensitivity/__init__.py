"""Experimental, used by no run: the gradient of the peak stress of a short drop with respect to the vertices."""
