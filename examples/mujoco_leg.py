"""Go from the MJCF file of a leg to its wiring, a vanilla baseline, and the gait that it makes.

Put a file of your own in the place of `my_leg.xml`. Needs: pip install 'tegotae[mujoco]'
"""

from dataclasses import replace
from pathlib import Path

from tegotae.envs import save_wiring
from tegotae.envs.env_spec import EnvSpec
from tegotae.envs.mujoco.settings import ModelSettings, model_files
from tegotae.figures.rollout import episode_figure
from tegotae.figures.style import save_figure
from tegotae.systems.recipe import recipe
from tegotae.training.environments.experiment import EnvExperiment
from tegotae.training.environments.objectives import Return
from tegotae.training.environments.replay import replay
from tegotae.training.scoring import sweep_vanilla
from tegotae_robots.models.suggesting import suggest_wiring

Path("my_leg.xml").write_text(model_files()["leg"])

# Feet, limbs, pushes, scales, frequency and rest length follow from the model.
suggested = suggest_wiring(ModelSettings(model="my_leg.xml"))
wiring = suggested.wiring
for i, limb in enumerate(wiring.limbs):
    print(f"{limb.drives}: push {limb.push:g} N m, {suggested.reasons[f'limbs[{i}].push']}")
save_wiring(wiring, "my_leg.toml", reasons=suggested.reasons)

# The vanilla controller: which gain and frequency carry the leg furthest for its work?
experiment = EnvExperiment.from_recipe(
    recipe("V-sector-w8"),
    EnvSpec(env="my_leg.xml").for_wiring(wiring),
    wiring,
    objective=Return(),
    duration_s=3.0,
)
sweep = sweep_vanilla(experiment, [13.1, 17.5])
row, column = sweep.best
sigma, omega = float(sweep.sigma[row]), float(sweep.omega[column])
print(f"best: sigma {sigma:.3g} rad/(s N) at omega {omega:g} rad/s")

# Its gait, measured and drawn.
best = replace(experiment, wiring=replace(experiment.wiring, omega=omega))
(gait,) = replay(best, [[sigma]])
for name, value in gait.numbers().items():
    print(f"{name}: {value:.3g}")
save_figure(episode_figure(gait, note="a leg of one's own"), "mujoco_leg.png")

# Feedback is worth more than the bare rhythm (sigma = 0), and the leg goes forward.
assert sweep.fitness[row, column] > sweep.fitness[0, column] + 0.1
assert gait.numbers()["distance_m"] > 0.2
