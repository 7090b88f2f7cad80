"""Wire an oscillator to an environment: the observations that a limb's oscillator reads, and the
action entry that it drives; as a file, TOML or JSON, written by people, read back and checked."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from tegotae._support import documents
from tegotae._support.documents import DamagedDocumentError, JsonObject, as_json
from tegotae._support.errors import TegotaeError, require_finite, unknown
from tegotae._support.files import write_atomically
from tegotae.envs._types import AnyEnv
from tegotae.envs.scaling import body_scales, model_scales, units_of
from tegotae.parts.controller import Controller
from tegotae.parts.oscillators import PhaseOscillator
from tegotae.parts.terms import Sector
from tegotae.parts.units import Units
from tegotae.systems.controller_file import SavedController, load
from tegotae.systems.env_documents import ROBOT_FORMAT, WIRING_FORMAT, RobotDocument, WiringDocument
from tegotae.systems.recipe import recipe
from tegotae.systems.registry import is_reference, require_named
from tegotae.systems.resolve import resolve
from tegotae.systems.tuned import is_front_name
from tegotae.systems.zoo import is_zoo_name

_PACKAGED = Path(__file__).parent / "mujoco" / "wirings"

NOTHING = "0"
"""Entry of a signal that is always zero, such as the pitch of a leg in the middle of the trunk."""


@dataclass(frozen=True, kw_only=True)
class Limb:
    """One limb: an oscillator with its senses and its drives.

    Args:
        senses: for each signal that the controller reads (such as `spring_force`, `velocity`), the
            name of the observation entry that it is, with a minus before it if its sign is the
            other way, or "0" for a signal that is always zero. The contact force, or better a
            spring's, goes under `spring_force`; what is below zero there counts as zero.
        drives: name of the action entry; of a controller that commands places of a foot those of
            its entries, forward, up and, for one that steps aside, to the left.
        rest: value of that entry where the actuator force is zero; the middle of its bounds if
            None. Commanded places are the action itself.
        push: its value at full force; its upper bound if None.
        phase_rad: phase at reset [rad].
    """

    senses: Mapping[str, str]
    drives: str | Sequence[str]
    rest: float | None = None
    push: float | None = None
    phase_rad: float = 0.0

    @property
    def entries(self) -> tuple[str, ...]:
        """The action's entries that it drives."""
        return (self.drives,) if isinstance(self.drives, str) else tuple(self.drives)


@dataclass(frozen=True, kw_only=True)
class Wiring:
    """Wiring of Tegotae control into an environment: `TegotaeWrapper(env, wiring)`.

    Every limb has a phase oscillator `φ̇ = ω + f` with the feedback `f = G · A′(φ) · R(s)` of its
    own senses, and the controller's actuation makes of them a force in [0, α], which becomes the
    action `rest + (push - rest) · F_a / α`.

    A wiring without weights is one that is to be trained (`tegotae train --env`). `tegotae.envs`
    reads and writes wirings as files: `load_wiring`, `save_wiring`.

    Raises:
        TegotaeError: for a sector that is none.
    """

    limbs: Sequence[Limb]
    """The limbs."""
    weights: ArrayLike | None = None
    """The controller's weights, shape [n_weights], or [limbs, n_weights]; σ for the vanilla one."""
    omega: float | None = None
    """Prescribed frequency ω [rad/s]."""
    controller: Controller = field(default_factory=lambda: recipe("V-sector-w8").controller())
    """Terms, oscillator and actuation: of one limb, the same for all; or of all of them, with its
    own sharing and coupling. The vanilla sector by default."""
    scales: Mapping[str, float] = field(default_factory=dict)
    """Divisor of each signal for a network, such as the weight for `spring_force`, and √(g/l0) for
    `feedback`; 1 if not named. `with_scales` takes them from a MuJoCo model, `from_controller` from
    the body that the controller was trained on."""
    units: Units | None = None
    """Values of 1 m, 1 s and 1 N of the controller here; unscaled if None. With those of the body,
    l0, √(l0 / g) and its weight, a controller from elsewhere is scaled by Froude, and so is one
    that is trained here."""
    max_force: float = 4.0
    """The force α at which the action is `push`, in the units of the actuation's force."""
    sector_rad: Sequence[float] | None = None
    """Sector of the phase in which a limb of this body pushes under a controller with a sector,
    which takes it over: [start, width]. The controller's own if None, which in the paper's models
    is a twentieth of a turn; [π, π] pushes for as long as the oscillator believes in stance."""
    max_feedback_rad_per_s: float = 10.0
    """Feedback that an agent's action of 1 adds to a limb's own [rad/s]."""
    step_s: float | None = None
    """Time between two steps of the environment [s]; its own `dt` if None."""
    observation_names: Sequence[str] | None = None
    """Names of the observation's entries, if those of `naming.observation_names` do not do."""
    action_names: Sequence[str] | None = None
    """Names of the action's entries, in the same way."""
    contact_bodies: Sequence[str] = ()
    """Bodies of a MuJoCo model whose contact forces are observed as `BODY_force`
    (`MujocoContactForce`), in an environment that does not observe them itself."""
    height: str | None = None
    """The observation entry that is the body's height [m]; with `work` CoT⁻¹ and ΔΩ are known."""
    work: str | None = None
    """The observation entry that is the actuators' work since the reset [J], counted absolutely."""
    work_positive: str | None = None
    """The one that is their positive work alone [J], if it is measured."""
    work_net: str | None = None
    """The one that is their signed work [J], if it is measured."""
    rest_length_m: float | None = None
    """The height at which the feet touch and leave the ground, in `height`'s terms [m]."""

    def __post_init__(self) -> None:
        if self.sector_rad is None:
            return
        if len(self.sector_rad) != 2:
            raise TegotaeError(
                f"sector_rad is {list(self.sector_rad)!r}; it must be two numbers, where the "
                "sector starts and how wide it is [rad]"
            )
        require_finite("the width in sector_rad", self.sector_rad[1], above=0.0, most=2.0 * math.pi)
        actuation = self.controller.actuation
        if isinstance(actuation, Sector):
            start_rad, width_rad = map(float, self.sector_rad)
            push = dataclasses.replace(actuation, start_rad=start_rad, width_rad=width_rad)
            controller = dataclasses.replace(self.controller, actuation=push)
            object.__setattr__(self, "controller", controller)

    @classmethod
    def from_controller(
        cls, file: Path | str, wiring: Wiring | Path | str | None = None, **changes: object
    ) -> Wiring:
        """Return the wiring of a controller file.

        A controller that was trained on an environment has the wiring that it was trained with.
        Another one, such as the hopper's, needs a wiring, for what its limbs are elsewhere. Its
        networks go on seeing signals over the scales of the body that it was trained on; those that
        the wiring gives go before, such as another body's of `with_scales`.

        Args:
            file: what `tegotae train` wrote.
            wiring: limbs, scales and names, or a file of them; the controller's own by default.
            changes: fields of the wiring to set otherwise, such as `scales`.

        Raises:
            TegotaeError: for a file that is none, or a controller without a wiring where none is
                given.

        Example:
            >>> Wiring.from_controller("leg.json", "leg.toml", omega=9.0)  # doctest: +SKIP
        """
        saved = load(file)
        if isinstance(wiring, (str, Path)):
            wiring = load_wiring(wiring)
        if wiring is None:
            if saved.task is None:
                raise TegotaeError(
                    f"{file} was not trained on an environment, so that it does not say what its "
                    "limbs are wired to; give a wiring"
                )
            wiring = wiring_of(saved.task.wiring)
        return dataclasses.replace(wiring.holding(saved), **changes)

    def holding(self, saved: SavedController) -> Wiring:
        """Return this wiring with a saved controller: its structure, weights, frequency and α.

        Scales that are not given are those of the body that it was trained on. With units, all
        scales and the frequency are its own, in proportion: every limb is as it was there.

        Raises:
            TegotaeError: for a controller without an oscillator.
        """
        if saved.controller.oscillator is None:
            raise TegotaeError("the controller has no oscillator; take one that has, such as ART")
        reads = {*read_by(saved.controller), "feedback"}
        body, units, omega = saved.system.body, self.units, saved.omega
        scales = {name: x for name, x in body_scales(body).items() if name in reads}
        if units is None:
            scales |= self.scales
        else:
            was, units = _units_of(saved, units)
            scales = {
                name: x / was.value_of(name) * units.value_of(name) for name, x in scales.items()
            }
            scales = {**self.scales, **scales}
            omega = None if omega is None else omega * was.time_s / units.time_s
        return dataclasses.replace(
            self.reading(saved.controller),
            scales=scales,
            units=units,
            weights=saved.weights,
            omega=omega,
            max_force=self.max_force if body.max_force_n is None else float(body.max_force_n),
        )

    def reading(self, controller: Controller) -> Wiring:
        """Return this wiring with another controller, without the senses that none of its terms
        reads.

        So are axes of a foot that it does not command.
        """
        reads, actuation = read_by(controller), controller.actuation
        driven = slice(None if actuation.commands_force else len(actuation.COMMANDS))
        limbs = tuple(
            dataclasses.replace(
                limb,
                senses={name: entry for name, entry in limb.senses.items() if name in reads},
                drives=limb.drives if isinstance(limb.drives, str) else limb.drives[driven],
            )
            for limb in self.limbs
        )
        return dataclasses.replace(self, controller=controller, limbs=limbs)

    def with_scales(self, env: AnyEnv) -> Wiring:
        """Return this wiring with missing scales taken from the environment's MuJoCo model.

        Raises:
            TegotaeError: for an environment without one, or a scale whose name has a slip.
        """
        feet = self.contact_bodies or None
        scales = model_scales(env, feet=feet, limbs=len(self.limbs))
        if problems := misnamed_scales(self.scales, list(scales)):
            raise TegotaeError("; ".join(problems))
        return dataclasses.replace(self, scales={**scales, **self.scales})


def _units_of(saved: SavedController, local: Units) -> tuple[Units, Units]:
    """Return the units of a controller where it was trained, and those on a body of these units.

    One from another simulator counts in the units of its wiring.
    """
    if saved.task is not None:
        return wiring_of(saved.task.wiring).units or Units(), local
    return Units(), local.over(units_of(saved.system.mechanics))


def misnamed_scales(scales: Mapping[str, float], signals: Sequence[str]) -> list[str]:
    """Return a sentence for every scale whose name is close to a signal's but unknown, and has no
    effect.

    Scales of other names may be for other controllers.

    Example:
        >>> misnamed_scales({"velocty": 1.0, "pressure": 2.0}, ["velocity", "feedback"])
        ["scales: no signal is called 'velocty'; did you mean velocity?"]
    """
    lacking = [name for name in signals if name not in scales]
    return [
        f"scales: no signal is called {name!r}; did you mean {near[0]}?"
        for name in scales
        if name not in signals and (near := get_close_matches(name, lacking, n=1, cutoff=0.8))
    ]


def read_by(controller: Controller) -> list[str]:
    """Return the signals that a controller's terms read, and that an environment must provide.

    Example:
        >>> from tegotae.systems.recipe import recipe
        >>> read_by(recipe("AR-rFv-reflex-w8").controller())
        ['spring_force', 'velocity']
    """
    internal = {"feedback", *(controller.oscillator or PhaseOscillator()).SIGNALS}
    return sorted(controller.reads - internal)


def load_wiring(path: Path | str) -> Wiring:
    """Load the wiring of a TOML or JSON file, or one that comes with the package, by its name.

    Args:
        path: a file that ends in `.toml` or `.json`, a wiring's or a robot's; or `hopper`, `leg` or
            `quadruped`.

    Raises:
        TegotaeError: if there is none, or it is no wiring: which entry, what is there and what
            should be.

    Example:
        >>> load_wiring("hopper").limbs[0].drives
        'leg'
    """
    if str(path) in packaged():
        return load_wiring(_PACKAGED / f"{path}.toml")
    path = Path(path)
    if path.suffix not in (".toml", ".json"):
        if path.name == str(path) and not path.exists():
            raise unknown("wiring", str(path), packaged())
        raise TegotaeError(f"{path} is no wiring; its name must end in .toml or .json")
    try:
        return wiring_of(documents.read(path), path.parent)
    except OSError as error:
        raise TegotaeError(f"cannot read {path}: {error.strerror}") from None
    except DamagedDocumentError as error:
        raise TegotaeError(f"{path} is no wiring: {error}") from None


def save_wiring(
    wiring: Wiring, path: Path | str, *, reasons: Mapping[str, str] | None = None
) -> None:
    """Write a wiring, TOML or JSON by the name's end; all but its controller and weights.

    Args:
        wiring: the wiring.
        path: its file.
        reasons: comments behind entries of a TOML file, by names such as `omega`,
            `scales.velocity`, `limbs[0].push` and, of a sense, `limbs[0].spring_force`.

    Raises:
        TegotaeError: for a name of another end, or if it cannot be written.
    """
    path = Path(path)
    document = wiring_document(wiring)
    if path.suffix == ".json":
        write_atomically(path, json.dumps(document, indent=1) + "\n")
    elif path.suffix == ".toml":
        write_atomically(path, toml_of(document, reasons or {}))
    else:
        raise TegotaeError(f"{path} is no wiring; its name must end in .toml or .json")


def wiring_document(wiring: Wiring) -> JsonObject:
    """Return a wiring as plain JSON values, without its controller and weights.

    Example:
        >>> wiring_document(load_wiring("hopper"))["height"]
        'root_height'
    """
    limbs = [
        {
            "senses": dict(limb.senses),
            "drives": limb.drives if isinstance(limb.drives, str) else list(limb.drives),
            **_nonempty({"rest": limb.rest, "push": limb.push, "phase_rad": limb.phase_rad}),
        }
        for limb in wiring.limbs
    ]
    plain = (field.name for field in dataclasses.fields(wiring) if field.name not in _OTHERWISE)
    return {
        "format": WIRING_FORMAT,
        **_nonempty({name: getattr(wiring, name) for name in plain}),
        **({} if wiring.units is None else {"units": dataclasses.asdict(wiring.units)}),
        "scales": {name: float(scale) for name, scale in wiring.scales.items()},
        "limbs": limbs,
    }


def wiring_of(document: object, folder: Path | None = None) -> Wiring:
    """Return the wiring of plain JSON values.

    Args:
        document: what `wiring_document` made, or a file holds.
        folder: where a controller file that it names is looked for.

    Raises:
        DamagedDocumentError: for values that are no wiring's.
        TegotaeError: for a controller file that cannot be read, or code that the user did not name
            (`require_named`).
    """
    if not isinstance(document, WiringDocument):
        document = documents.checked(document)
        is_robot = isinstance(document, dict) and document.get("format") == ROBOT_FORMAT
        document = documents.fitted(document, RobotDocument if is_robot else WiringDocument)
    if document.format not in (WIRING_FORMAT, ROBOT_FORMAT):
        raise DamagedDocumentError(
            f"its format is {document.format!r}; it must be {WIRING_FORMAT!r}"
        )
    if document.omega is not None and not 0.0 < document.omega < math.inf:
        raise DamagedDocumentError(f"its omega is {document.omega}; it must be above 0")
    fields: dict[str, Any] = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in msgspec.structs.asdict(document).items()
        if name not in ("format", "controller", "limbs", "model")
    }
    limbs: list[Limb] = []
    for limb in document.limbs:
        drives = limb.drives if isinstance(limb.drives, str) else tuple(limb.drives)
        limbs.append(Limb(**{**msgspec.structs.asdict(limb), "drives": drives}))
    units = document.units
    fields["units"] = Units(**msgspec.structs.asdict(units)) if units else None
    if document.weights is not None:
        fields["weights"] = np.asarray(document.weights)
    wiring = Wiring(limbs=tuple(limbs), **fields)
    if document.controller is None:
        return wiring
    held = wiring.holding(_controller(document.controller, folder or Path()))
    return held if document.omega is None else dataclasses.replace(held, omega=document.omega)


def _controller(name: str, folder: Path) -> SavedController:
    """Return the controller of a name: a file beside the wiring, or a name that is known
    everywhere.
    """
    beside = folder / name
    is_file = beside.exists() or (beside.suffix == ".json" and not is_reference(name))
    meant = str(beside if is_file else name)
    if not is_zoo_name(meant) and not is_front_name(meant):
        require_named(meant, "the wiring")
    return resolve(meant).controller()


def packaged() -> list[str]:
    """Return the names of the wirings that come with the package, for its MuJoCo models."""
    return sorted(file.stem for file in _PACKAGED.glob("*.toml"))


_OTHERWISE = ("limbs", "weights", "controller", "scales", "units")
"""Fields of a wiring that a document has in another form, or not."""


def _nonempty(values: Mapping[str, str | float | Sequence[Any] | None]) -> JsonObject:
    """Return the entries that are not None and not empty, with numbers of JSON."""
    return {
        name: float(value) if isinstance(value, (int, float)) else as_json(value)
        for name, value in values.items()
        if value is not None and value not in ((), [])
    }


def toml_of(document: Mapping[str, Any], reasons: Mapping[str, str]) -> str:
    """Return a wiring's or a robot's document as TOML.

    Args:
        document: texts, numbers, lists of texts, tables and one list of tables.
        reasons: comments behind entries, as of `save_wiring`.
    """

    def line(name: str, value: Any, prefix: str = "") -> str:
        reason = reasons.get(prefix + name)
        key = name if name.isidentifier() else json.dumps(name)
        if isinstance(value, Mapping):
            text = f"{{{', '.join(line(*pair) for pair in value.items())}}}"
        else:
            text = json.dumps(value)
        return f"{key} = {text}" + (f"  # {reason}" if reason else "")

    plain = {n: x for n, x in document.items() if not isinstance(x, dict) and n != "limbs"}
    lines = [line(name, value) for name, value in plain.items()]
    for table in (name for name, x in document.items() if isinstance(x, dict)):
        entries = (line(n, x, f"{table}.") for n, x in document[table].items())
        lines += ["", f"[{table}]", *entries]
    for i, limb in enumerate(document["limbs"]):
        prefix = f"limbs[{i}]."
        own = [line(n, x, prefix) for n, x in limb.items() if n != "senses"]
        senses = [line(n, x, prefix) for n, x in limb["senses"].items()]
        lines += ["", "[[limbs]]", *own, "[limbs.senses]", *senses]
    return "\n".join(lines) + "\n"
