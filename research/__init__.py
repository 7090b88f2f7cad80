"""Research with the package: the study of the paper, further studies, benchmarks."""
