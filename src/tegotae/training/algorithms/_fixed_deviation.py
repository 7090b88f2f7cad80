"""evosax's OpenAI-ES with its deviation as data."""

from evosax.algorithms import Open_ES


class FixedDeviation(Open_ES):
    """OpenAI-ES that keeps the deviation in its state: evosax's is a part of the program."""

    def _tell(self, key, population, fitness, state, params):
        return super()._tell(key, population, fitness, state, params).replace(std=state.std)
