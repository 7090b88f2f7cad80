"""Parts of a closed loop: bodies, terrains, oscillators, terms, couplings, controllers."""
