"""The grammar of recipes, one for the hopper and for legs."""

import hashlib
import json

import pytest

from refusals import refused
from tegotae import TegotaeError
from tegotae.systems.recipe import recipe, recipes_on_legs, study_recipes
from tegotae.systems.term_sets import learned_terms


def digest(recipes) -> str:
    """A hash of names, and of the weights of each term."""

    def sizes(controller):
        return [(term, value.n_weights) for term, value in sorted(controller.terms.items())]

    lines = [f"{name} {sizes(entry.controller())}" for name, entry in recipes.items()]
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


def test_names_and_sizes_of_the_models_never_change():
    assert digest(study_recipes()) == (
        "ed78c52f01d5a0c3afa001027008c6357bc19f0139d65968e8954b8a73630454"
    )


def test_names_and_sizes_of_the_listed_designs_never_change():
    assert digest(recipes_on_legs()) == (
        "8abfd4c627359d884051166120817ce67c65599d2ab9cb7039b6f63314b87e03"
    )


def test_documents_of_recipes_never_change():
    documents = {
        name: entry.experiment().document
        for name, entry in {**study_recipes(), **recipes_on_legs()}.items()
    }
    text = json.dumps(documents, sort_keys=True)
    assert hashlib.sha256(text.encode()).hexdigest() == (
        "b5a7c6567f224380863b122231101fabba839f0b0367bc5c9a77f106c43636b9"
    )


@pytest.mark.parametrize("name", ["V", "VG", "AR", "ART", "ARG", "ARGT", "R-rFv", "VT-tphi"])
def test_a_name_means_the_same_terms_for_the_hopper_and_for_legs(name):
    terms = learned_terms(name)
    assert terms is not None
    assert recipe(name).terms == terms
    assert recipe(f"{name}@plate-light-pitch").terms.name == terms.name


@pytest.mark.parametrize(
    ("name", "senses"),
    [
        ("AR-rFv@plate-light-pitch", ("spring_force", "velocity")),
        ("AR-rFr@quadruped-c", ("spring_force", "spring_force_rate")),
        ("AR-rFa@plate-light-pitch", ("spring_force", "pitch", "roll")),
    ],
)
def test_a_name_says_what_the_legs_sense(name, senses):
    controller = recipe(name).controller()
    assert controller.tegotae is not None
    assert controller.tegotae.reaction.reads == senses
    assert set(senses) <= set(recipe(name).system.body.SENSES)


def test_an_observation_means_the_same_senses_on_every_body():
    of_plate = recipe("R-rFv@plate-light-pitch").controller().terms
    assert recipe("R-rFv").controller().terms["reaction"].reads == of_plate["reaction"].reads
    with pytest.raises(TegotaeError, match="does not sense its load and the velocity of its hip"):
        recipe("AR-rFv@quadruped-c").controller()
    refused("no observation is called 'Fx'", lambda: recipe("AR-rFx@quadruped-c").controller())


def test_a_name_gives_its_terms_back():
    for model in study_recipes().values():
        if model.omega_t is not None:
            assert learned_terms(model.terms.name) == model.terms


def test_what_is_no_name_has_no_terms():
    assert [learned_terms(name) for name in ("", "RA", "T-F", "ART_rF", "ARTG")] == [None] * 5


def test_a_sense_of_a_term_that_is_not_learned_is_refused():
    refused("says what G senses, and it is not learned", learned_terms, "AR-gF")
