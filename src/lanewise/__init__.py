"""Pure JAX functions as native code over lanes: traced, taken apart to a graph of scalars, and
written as vector code of the processor. It knows nothing of what the functions compute."""
