"""MechStyle: stylize a 3D-printable model from a prompt while a drop test watches its strength."""
