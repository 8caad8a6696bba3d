"""The state shared by the Studio's widgets, and the controller that carries runs on."""
