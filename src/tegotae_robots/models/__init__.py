"""Models of robots: a first wiring, a walker that stands for one, and how far the two are apart."""
