"""Many runs compared: cells of a study, a class."""
