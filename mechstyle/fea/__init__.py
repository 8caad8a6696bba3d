"""The drop test: elasticity, explicit dynamics with contact, and the stress that a volume exceeds."""
