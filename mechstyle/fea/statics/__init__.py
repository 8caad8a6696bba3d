"""Linear statics: where loads and supports act, one factorisation for the cases that share it, the test of a part."""
