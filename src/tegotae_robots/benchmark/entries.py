"""An entry of the benchmark, of whatever kind, as a function that begins episodes."""

from __future__ import annotations

import copy
import ctypes
import dataclasses
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tegotae._support.errors import TegotaeError
from tegotae.systems.controller_file import SavedController
from tegotae.systems.registry import is_reference, load_object
from tegotae.systems.resolve import resolve
from tegotae.systems.tuned import is_front_name
from tegotae.systems.zoo import is_zoo_name
from tegotae.training.collection import controller_of
from tegotae_robots.benchmark.manifest import Manifest, read_manifest
from tegotae_robots.benchmark.subject import Entry, Policy, Subject, of_limbs
from tegotae_robots.c.plan import member
from tegotae_robots.live.controller import LiveController
from tegotae_robots.robot import compiled

if TYPE_CHECKING:
    from tegotae_robots.benchmark.go1 import Go1Subject


def read_entry(place: Any, subject: Subject, track: str) -> Entry:
    """Read an entry that uses the senses of a track.

    Args:
        place: a name or a file of a controller; `FILE.py:OBJECT` or `MODULE:OBJECT`, of a function
            from observation to action or a class of such functions with a state; a network, .onnx,
            or .zip of Stable-Baselines3; a C file of `tegotae export c`; or an object.
        subject: what it drives.
        track: what it senses.

    Raises:
        TegotaeError: for none of these, one that senses more than the track has, or one that
            commands something else.
        MissingExtraError: without the package that reads its file.
    """
    text = str(place) if isinstance(place, str | Path) else ""
    suffix = Path(text).suffix.lower()
    if suffix == ".c":
        return _c_entry(Path(text), subject, track)
    if suffix in _NETWORKS:
        return _network_entry(Path(text), subject, track)
    policy: Any = load_object(text, object, "entry") if _is_object(text) else place
    if callable(policy):
        begin: Any = policy if isinstance(policy, type) else lambda: copy.deepcopy(policy)
        return begin
    saved = controller_of(resolve(place))
    return (_controller_entry if saved.task is None else _wiring_entry)(saved, subject, track)


_NETWORKS = (".onnx", ".zip")


def _is_object(text: str) -> bool:
    """Return True if a text names an object in a file or a module."""
    return is_reference(text) and not (is_zoo_name(text) or is_front_name(text))


def is_program(place: Any) -> bool:
    """Return True if a place names code or a network of its author's, which need not end.

    Example:
        >>> is_program("leg.c"), is_program("mine.py:Trot"), is_program("zoo:ART/3")
        (True, True, False)
    """
    text = str(place) if isinstance(place, str | Path) else ""
    return Path(text).suffix.lower() in (".c", *_NETWORKS) or _is_object(text)


def _indices(names: Sequence[str], entries: Sequence[str], verb: str) -> np.ndarray:
    """Return the indices of names among the entries."""
    for name in names:
        if name not in entries:
            raise TegotaeError(f"the entry {verb} {name}; here are {', '.join(entries)}")
    return np.array([entries.index(name) for name in names], int)


def _controller_entry(saved: SavedController, subject: Subject, track: str) -> Entry:
    """Compile a controller of the package's own bodies to native code."""
    native = compiled(saved)
    sensed = _indices(of_limbs(native.senses, native.limbs), subject.senses[track], "senses")
    _indices(subject.commands, of_limbs(native.commands, native.limbs), "does not command")
    live, shape = LiveController(native), (len(native.senses), native.limbs)

    def begin() -> Policy:
        fresh = copy.copy(live)
        fresh.reset()

        def policy(observed: np.ndarray) -> np.ndarray:
            felt = dict(zip(native.senses, observed[sensed].reshape(shape), strict=True))
            return fresh.step(felt, dt_s=subject.step_s).ravel()

        return policy

    return begin


def _go1(subject: Subject, name: str | None) -> Go1Subject:
    """Return the robot that a controller on limbs drives."""
    from tegotae_robots.benchmark.go1 import Go1Subject

    if not isinstance(subject, Go1Subject):
        raise TegotaeError(f"{name} was trained in another simulator; its subject is go1")
    return subject


def _wiring_entry(saved: SavedController, subject: Subject, track: str) -> Entry:
    """Return the entry of a controller that was trained on an environment, by its wiring."""
    from tegotae.envs.mujoco.sensing import sensing
    from tegotae.envs.wrapper import Pilot
    from tegotae.training.environments.experiment import EnvExperiment

    robot, experiment = _go1(subject, saved.name), EnvExperiment.from_controller(saved)
    legs = experiment.spec.is_model and experiment.spec.model_settings.legs
    wiring = dataclasses.replace(experiment.wiring, step_s=robot.step_s)
    trained = dataclasses.replace(experiment, spec=robot.spec(legs), wiring=wiring)
    commanded = sensing(trained.spec.model_settings)
    observed = trained.wires.observed
    felt = {observed[i] for places, _ in trained.wires.sensed.values() for i in places}
    _indices(sorted(felt), subject.senses[track], "senses")
    columns = _indices(subject.senses[track], observed, "senses")
    weights = np.asarray(saved.weights, np.float32)[:, None]

    def begin() -> Policy:
        pilot, observation = (
            Pilot(trained.wires, trained.wiring, weights),
            np.zeros((1, len(observed))),
        )

        def policy(values: np.ndarray) -> np.ndarray:
            observation[0, columns] = values
            return commanded.controls(pilot.act(observation))[0]

        return policy

    return begin


def _network_entry(path: Path, subject: Subject, track: str) -> Entry:
    """Return the entry of a network, which has no state."""
    from tegotae.envs.policies import network

    answer, entries = network(path)
    senses = subject.senses[track]
    if entries not in (None, len(senses)):
        raise TegotaeError(
            f"{path} observes {entries} numbers; on the track {track} there are {len(senses)}: "
            f"{', '.join(senses)}"
        )
    return lambda: lambda observation: np.asarray(answer(observation[None]))[0]


def _c_entry(path: Path, subject: Subject, track: str) -> Entry:
    """Compile a program of `tegotae export c` with cc; oscillators begin at the phases of its
    wiring, or spread over the turn.
    """
    manifest = read_manifest(path)
    if abs(manifest.tick_s / subject.step_s - 1.0) > 1e-3:
        raise TegotaeError(
            f"{path} is for a loop of {manifest.tick_s:g} s; export it for that of the subject, "
            f"--tick-s {subject.step_s:g}"
        )
    limbs, wired, commanded = manifest.limbs, manifest.wired, manifest.commanded
    inputs, outputs = ([x.name for x in numbers] for numbers in (manifest.inputs, manifest.outputs))
    commands, controls = subject.commands, lambda action: action
    rest, push, scale = 0.0, 1.0, 1.0
    if wired:
        places = [{member(name): entry for name, entry in x.senses.items()} for x in wired]
        felt = [x[name] for name in inputs for x in places]
        driven = [np.atleast_1d(x.drives)[k] for k in range(len(commanded)) for x in wired]
        if manifest.legs:
            from tegotae.envs.mujoco.sensing import sensing

            legged = sensing(_go1(subject, path.stem).spec(legs=True).model_settings)
            commands, controls = legged.actions, lambda action: legged.controls(action[None])[0]
        else:
            rest, push = (np.array([getattr(x, end) for x in wired]) for end in ("rest", "push"))
            scale = manifest.constants["max_force_n"]
    else:
        of_c = {_in_c(name): name for name in (*subject.senses["all"], *subject.commands)}
        felt = [of_c.get(name, name) for name in of_limbs(inputs, limbs)]
        driven = [of_c.get(name, name) for name in of_limbs(commanded, limbs)]
        _indices(subject.commands, driven, "does not command")
    sign = np.array([-1.0 if name.startswith("-") else 1.0 for name in felt])
    sensed = _indices([name.removeprefix("-") for name in felt], subject.senses[track], "senses")
    drives = _indices(driven, commands, "commands")
    phases = manifest.phases_rad
    start = ctypes.c_float(phases[0]) if limbs == 1 else (ctypes.c_float * limbs)(*phases)
    library, prefix = _compiled(path, manifest), manifest.prefix
    initialise, step = library[f"{prefix}_init"], library[f"{prefix}_step"]
    size = ctypes.c_ulong.in_dll(library, "entry_state_bytes").value

    def begin() -> Policy:
        state = ctypes.create_string_buffer(size)
        input_values, output_values = (
            np.zeros((len(x) + 1) * limbs + 1, np.float32) for x in (inputs, outputs)
        )
        pointers = (
            state,
            *(x.ctypes.data_as(ctypes.c_void_p) for x in (input_values, output_values)),
        )
        action = np.zeros(len(commands))
        initialise(state, *([start] if manifest.state else []))

        def policy(observation: np.ndarray) -> np.ndarray:
            input_values[: len(sensed)] = sign * observation[sensed]
            step(*pointers)
            action[drives] = rest + (push - rest) * output_values[: len(drives)] / scale
            return controls(action)

        return policy

    return begin


def _in_c(name: str) -> str:
    """Return the name of an entry as C has it.

    Example:
        >>> _in_c("spring_force[2]")
        'spring_force_n[2]'
    """
    plain, bracket, limb = name.partition("[")
    return f"{member(plain)}{bracket}{limb}"


_MOST_CC_S = 120
"""Time limit of the compiler for an entry [s]."""


def _compiled(path: Path, manifest: Manifest) -> ctypes.CDLL:
    """Load the program into this process, and return it with the size of its state."""
    text = f'#include "{path.resolve()}"\n{manifest.checks()}'
    text += f"const unsigned long entry_state_bytes = sizeof({manifest.prefix}_state);\n"
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "entry.so"
        words = ["cc", "-std=c99", "-O2", "-shared", "-fPIC", "-Werror=incompatible-pointer-types"]
        words += ["-x", "c", "-", "-lm", "-o"]
        try:
            process = subprocess.run(
                [*words, target], input=text, capture_output=True, text=True, timeout=_MOST_CC_S
            )
        except FileNotFoundError:
            raise TegotaeError(f"{path} needs a C compiler, and there is no cc") from None
        except subprocess.TimeoutExpired:
            raise TegotaeError(f"cc took more than {_MOST_CC_S} s for {path}") from None
        if process.returncode:
            lines = process.stderr.splitlines()
            first = next((line for line in lines if "error" in line), "")
            if first.startswith("<stdin>"):  # the program compiles, the checks of it do not
                first = f"{path.stem}.json describes another program ({first})"
            raise TegotaeError(f"cc cannot compile {path}: {first}")
        return ctypes.CDLL(str(target))
