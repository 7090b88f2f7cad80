"""What learning adds: every run judged from common releases, whole and without its feedback."""
