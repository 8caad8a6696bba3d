"""Tools that styles draw with: surface charts, noise, scattered pieces, stripes, colours."""
