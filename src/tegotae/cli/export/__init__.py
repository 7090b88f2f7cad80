"""`tegotae export`: controllers as C, and what they cost on a microcontroller."""
