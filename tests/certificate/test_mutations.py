"""An adversary changes certificates: of those that are accepted none is false."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from benchmarks.attack.certificates.folders import AROUND, folder_of
from benchmarks.attack.certificates.judge import closest
from benchmarks.attack.certificates.mutations import WITNESSES, Case, largest, mutate, pack_witnesses
from planner.certificate import PROOF_NAME, verify_proof
from planner.certificate.verify_proof import Refused
from planner.collision import make_checker
from planner.trajectory.timing import time_path
from tests.worlds import make_post

MARGIN = 0.005  # m: what is nearer than that is a counterexample, long before it touches
RANDOM, CLIMBED = 60, 8  # 'python -m benchmarks attack' tries more


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> list[Case]:
    """A path, and a motion, each in a folder with its certificate."""
    post = make_post()
    checker = make_checker(post.robot, post.world.scene, margin=MARGIN)
    motion = time_path(AROUND, checker)
    made = []
    for name, moved in (("path", None), ("motion", motion)):
        folder, certificate = folder_of(tmp_path_factory.mktemp(name), checker, AROUND, moved)
        assert certificate.is_complete
        made.append(Case.from_folder(folder))
    return made


def judged_true(data: dict[str, np.ndarray], rng: np.random.Generator) -> bool:
    return closest(data, 6, rng, MARGIN) > MARGIN - 1e-7


def test_what_is_not_changed_is_accepted_and_true(cases: list[Case]) -> None:
    rng = np.random.default_rng(0)
    for case in cases:
        assert case.accepts(case.data, case.meta)
        assert judged_true(case.data, rng)


def test_no_false_certificate_is_accepted_of_many_changed_at_random(cases: list[Case]) -> None:
    rng, accepted = np.random.default_rng(1), dict[str, int]()
    for k in range(RANDOM):
        case = cases[k % 10 == 0]
        data, words, kind = mutate(case, rng)
        if case.accepts(data, words, follow=bool(rng.random() < 0.5)):
            accepted[kind] = accepted.get(kind, 0) + 1
            assert judged_true(data, rng), (kind, k)
    assert 0 < sum(accepted.values()) < 0.6 * RANDOM, accepted


def test_no_false_certificate_is_accepted_of_the_largest_changes_that_are(cases: list[Case]) -> None:
    rng, reached = np.random.default_rng(2), set[str]()
    for k in range(CLIMBED):
        case = cases[k % 10 == 0]
        found = largest(case, rng)
        if found is not None:
            data, name = found
            reached.add(name)
            assert judged_true(data, rng), (name, k)
    assert len(reached) >= 4, reached


def test_a_certificate_of_no_pair_is_refused(cases: list[Case]) -> None:
    """Pairs are said to be left out, with their witnesses, one after the other: all but one, then all."""
    case = cases[0]
    proven = np.flatnonzero(case.data["left"] == verify_proof.PROVEN)
    for kept in (1, 0):
        data = {name: array.copy() for name, array in case.data.items()}
        data["left"][proven[kept:]] = verify_proof.EXEMPT
        mine = (data["pair"] < kept) | (data["pair"] == len(proven))
        data |= {name: data[name][mine] for name in WITNESSES}
        data["pair"] = np.minimum(data["pair"], kept)
        said = case.accepts(pack_witnesses(data), case.meta)
        assert (said is not None) == (kept > 0)
    with pytest.raises(Refused, match=f"no pair of bodies is proven apart, {len(case.data['left'])} are left out"):
        verify_proof.check(case.folder)


def test_damaged_files_are_refused_in_one_sentence(cases: list[Case]) -> None:
    case, rng = cases[0], np.random.default_rng(3)
    assert case.accepts(case.data, case.meta)
    proof = case.folder / PROOF_NAME
    content = proof.read_bytes()
    for _ in range(100):
        broken = bytearray(content)
        at = rng.integers(len(broken), size=rng.integers(1, 9))
        broken[int(at[0])] ^= 1 << int(rng.integers(8))
        proof.write_bytes(bytes(broken) if rng.random() < 0.7 else content[: int(at[0])])
        _refused_or_the_same(case)
    proof.write_bytes(content)


def _refused_or_the_same(case: Case) -> None:
    try:
        verify_proof.check(case.folder)
    except Refused:
        return
    data, _ = verify_proof.read(case.folder / PROOF_NAME)
    assert all(np.array_equal(data[name], case.data[name]) for name in verify_proof.FIELDS if name != "meta")


def test_other_arrays_are_refused(cases: list[Case], tmp_path: Path) -> None:
    case = cases[0]
    assert case.accepts(case.data, case.meta)
    for name in verify_proof.FIELDS.keys() - {"meta"}:
        rest = {key: array for key, array in case.data.items() if key != name}
        assert not case.accepts(rest, case.meta, follow=False), name
    assert not case.accepts({**case.data, "more": np.zeros(1)}, case.meta)
    pickled = io.BytesIO()
    np.save(pickled, np.array([object()]), allow_pickle=True)
    proof = case.folder / PROOF_NAME
    with zipfile.ZipFile(proof, "a") as archive, pytest.warns(UserWarning, match="Duplicate name"):
        archive.writestr("points.npy", pickled.getvalue())
    with pytest.raises(Refused):
        verify_proof.check(case.folder)
    assert case.accepts(case.data, case.meta)
