"""Value of learning: every run judged from common releases, with its feedback and without."""
