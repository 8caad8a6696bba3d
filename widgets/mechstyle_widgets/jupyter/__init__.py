"""What Jupyter asks for: cell output, throttled updates, work in another process, inline SVG."""
