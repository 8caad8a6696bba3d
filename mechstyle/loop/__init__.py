"""The method: propose, restrain, simulate when it is worth it, remember."""
