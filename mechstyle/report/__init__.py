"""Self-contained HTML reports of a run, and the film of its iterations that report and notebook play."""
