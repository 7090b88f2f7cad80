"""Programs for a browser, beside the package."""
