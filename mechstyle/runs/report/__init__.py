"""Self-contained HTML reports of a run, and the replay data that report and notebook play."""
