"""One style program a file."""
