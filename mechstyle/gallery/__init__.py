"""Parametric printable models, in millimetres, standing as they are used."""
