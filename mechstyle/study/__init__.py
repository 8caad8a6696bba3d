"""Many runs compared: the four applications of the paper."""
