"""The settings column: one box for each group of the recipe's settings."""
