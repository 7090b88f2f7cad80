"""One code generator: traced functions as graphs of scalars, and these as native vector code."""
