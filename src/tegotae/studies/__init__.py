"""Questions asked of many controllers: studies, analyses, gaits, benchmarks."""
