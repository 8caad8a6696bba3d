"""Adapters to Jupyter: cell output, throttled updates, work in another process, inline SVG."""
