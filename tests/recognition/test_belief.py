import pickle

import numpy as np
import pytest

from pft_exec.recognition import Belief, LabelValues


def test_values_by_label_read_like_a_mapping():
    """Length, order, items, repr and pickle of the lazy mapping."""
    values = LabelValues({"a": 0, "b": 1}, np.array([0.25, 0.75]))
    assert dict(values) == {"a": 0.25, "b": 0.75}
    assert len(values) == 2
    assert repr(values) == "{'a': 0.25, 'b': 0.75}"
    assert dict(pickle.loads(pickle.dumps(values))) == dict(values)  # noqa: S301
    with pytest.raises(KeyError):
        values["c"]


def test_a_belief_cannot_be_changed():
    """Neither its fields nor its mappings."""
    belief = Belief("a", {"a": 1.0}, 0.0, {"a": 0.0}, {"a": 0.5}, {"a": 1.0})
    with pytest.raises(AttributeError):
        belief.label = "b"
    with pytest.raises(TypeError):
        belief.probability["a"] = 0.5
