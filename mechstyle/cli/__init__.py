"""The command line: one module a family of commands, one console they share."""
