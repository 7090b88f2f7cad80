"""placeholder"""
from dataclasses import dataclass
@dataclass(frozen=True)
class Bench:
    def run(self): ...
