"""What styles are drawn with: surface charts, noise, scattered pieces, stripes, colours."""
