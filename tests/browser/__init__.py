"""Tests in a browser: a package, so that what pytest calls a package's fixture ends with them and not with the session."""
