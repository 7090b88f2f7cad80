"""Pictures of gaits."""
