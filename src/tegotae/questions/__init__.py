"""Questions about controllers, their options and their answers: of a hopper, of legs, and of what
was trained in another simulator. Python and the command line both ask here."""
