"""Style programs, in families that share their ideas."""
