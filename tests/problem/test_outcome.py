"""How runs end: a key for files, a sentence for people, a code for scripts."""

from planner.problem.outcome import Outcome


def test_keys_codes_and_sentences() -> None:
    assert {outcome.key: outcome.exit_code for outcome in Outcome} == {
        "solved": 0,
        "no_path": 4,
        "too_singular": 4,
        "partly_followed": 4,
        "interrupted": 130,
    }
    for outcome in Outcome:
        assert outcome.value.endswith(".")
        assert any(word in outcome.value for word in ("--nodes", "widen")) == (outcome.exit_code == 4), (
            "an unsolved problem comes with a remedy"
        )
