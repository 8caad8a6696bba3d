"""What tests of several rooms share: where the repository is, runs without physics, lanes on a sheet."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
