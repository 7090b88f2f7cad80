"""Files, documents, locks, devices and errors: what every room stands on."""
