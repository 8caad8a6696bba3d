"""Every iteration of a run in the browser, without the kernel."""
