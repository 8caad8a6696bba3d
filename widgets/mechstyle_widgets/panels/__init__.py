"""Panels around the view: run controls, the mask inspector, branches."""
