"""A run from request to export: recipe, stylizer, session, summary, report."""
