"""A model that is trained on the scales of `wired_env.py`."""

from places import TESTS
from tegotae.envs import Limb, Wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.systems.recipe import recipe
from tegotae.training.environments.experiment import EnvExperiment

HERE = TESTS / "helpers"
ENV = f"{HERE / 'wired_env.py'}:Scales"
WIRING = Wiring(
    limbs=[Limb(senses={"spring_force": "load"}, drives="action[0]", rest=0.0)],
    scales={"spring_force": 1.0, "feedback": 3.0},
)


def experiment(model: str = "AR", *, env: str = ENV, budget: int = 12, **settings):
    """A model on the scales."""
    created = tuple(settings.pop("made", {}).items())
    wiring = settings.pop("wiring", WIRING)
    return EnvExperiment.from_recipe(
        recipe(model),
        EnvSpec(env=env, settings=created),
        wiring,
        **{"budget": budget, "duration_s": 0.8, **settings},
    )
