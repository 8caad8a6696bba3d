"""A picture file of the user's becomes pixels."""
