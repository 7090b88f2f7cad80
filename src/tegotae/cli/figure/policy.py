"""Options by which a figure is of anyone's policy instead of a controller."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import tyro

from tegotae._support.errors import TegotaeError, require_all
from tegotae.cli.figure.controller import SettledSubject
from tegotae.cli.options import UNSET
from tegotae.systems.presets import preset

if TYPE_CHECKING:
    from tegotae.analysis.orbit import Orbit
    from tegotae.envs.policies import Policy
    from tegotae.parts.bodies import Hopper
    from tegotae.systems.controller_file import SavedController

_ENVIRONMENTS = "(default: as in the package's environments)"


@dataclass(frozen=True, kw_only=True)
class PolicySubject(SettledSubject):
    """A figure of a controller, or of a policy."""

    HEADING = "Policy, in place of a controller"

    policy: Annotated[str | None, UNSET] = None
    """The policy: a .zip of Stable-Baselines3, an .onnx file, or FILE.py:FUNCTION, a function of
    some of phase_rad, spring_force_n, velocity_m_per_s and height_m. FILE.py runs as code, and
    other files are read by large libraries: take them from people that you trust."""
    acts: str = "force"
    """Meaning of its output: force of the actuator, or feedback of the oscillator."""
    observes: Annotated[tuple[str, ...], tyro.conf.arg(help_behavior_hint=_ENVIRONMENTS)] = ()
    """Observations of a .zip or .onnx, in its order: phase, spring_force, velocity, height."""
    si: bool = False
    """Observations are in N, m/s and m, and not relative to m g, √(g l0) and l0. A function always
    has these units."""
    answer_scale: Annotated[float | None, UNSET] = None
    """Force [N] or feedback [rad/s] for an output of 1; by default α or 40 rad/s, and 1 for a
    function."""
    step: float = 0.01
    """Time for which an output is held [s], a multiple of 1 ms."""

    def called(self) -> str:
        """The policy's name, or the controller's."""
        return super().called() if self.policy is None else self.policy

    def loaded(self) -> Policy | None:
        """The policy; None if the figure is of a controller.

        Raises:
            TegotaeError: for a controller beside a policy, a policy that cannot be loaded, or a
                policy's options without one.
        """
        if self.policy is None:
            self._check_unused()
            return None
        given = {self.path: self.path, "--sigma": self.sigma, "--oscillator": self.oscillator}
        for name, value in given.items():
            if value is not None:
                raise TegotaeError(f"{name} belongs to a controller; a policy has none")
        needed = {
            ".zip": {"gymnasium": "sb3", "stable_baselines3": "sb3"},
            ".onnx": {"gymnasium": "gym", "onnxruntime": "onnx"},
        }
        require_all(needed.get(Path(self.policy).suffix.lower(), {"gymnasium": "gym"}))
        from tegotae.envs.policies import Meaning, load_policy

        source = preset(self.preset)
        meaning = Meaning(
            acts=self.acts,
            observes=self.observes,
            dimensionless=not self.si,
            scale=self.answer_scale,
            omega=source.omega_rad_per_s if self.omega is None else self.omega,
            actuation=source.actuation if self.actuation is None else self.actuation,
            body=self.hopper(),
            step_s=self.step,
        )
        return load_policy(self.policy, meaning)

    @property
    def released(self) -> tuple[float, float]:
        """From which height [m] and phase [rad] a policy is released."""
        height_m = preset(self.preset).height_m if self.height is None else self.height
        return height_m, 0.0 if self.phase is None else self.phase

    def _check_unused(self) -> None:
        for each in ("acts", "observes", "si", "answer_scale", "step"):
            if getattr(self, each) != getattr(PolicySubject, each):
                option = "--" + each.replace("_", "-")
                raise TegotaeError(f"{option} belongs to a policy; name one with --policy")

    def title(self, driven: SavedController | Policy) -> str:
        """The policy, or the controller, in a few words, for a figure."""
        from tegotae.figures.style import literal

        if self.policy is None:
            return super().title(driven)
        at = f", ω = {driven.meaning.omega:g} rad/s" if driven.meaning.with_phase else ""
        return f"{literal(Path(driven.name).name)}{at}"

    def hopper_of(self, driven: SavedController | Policy) -> Hopper:
        """The hopper that a controller or a policy drives."""
        return driven.body if self.policy is None else driven.meaning.body

    def orbit(self, driven: SavedController | Policy) -> Orbit:
        """The limit cycle; raises `NoLimitCycleError` if there is none."""
        if self.policy is None:
            return super().orbit(driven)
        from tegotae.analysis.policy import measured_policy, policy_orbit, policy_paths

        height_m, phase_rad = self.released
        height = np.array([height_m])
        paths = policy_paths(driven, height, phase_rad=phase_rad, duration_s=self.settle)
        return policy_orbit(paths, measured_policy(driven, paths))
