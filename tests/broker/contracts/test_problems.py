"""Types of problems."""

from broker.contracts import ProblemType


def test_types_have_uris_of_their_own_named_as_in_the_code() -> None:
    slugs = [kind.slug for kind in ProblemType]
    assert len(set(slugs)) == len(slugs)
    assert all(kind.name == kind.slug.upper().replace("-", "_") for kind in ProblemType)
