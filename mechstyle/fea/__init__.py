"""The drop test: elasticity, explicit dynamics with contact, and what counts as viable."""
