from __future__ import annotations

import pytest

from handcart.backends.backend import Backend
from handcart.backends.registry import UnknownBackend, backend_names, make_backend
from handcart.backends.robot_loading import load_robot


def test_the_kinematic_backend_is_made_by_its_name(tmp_path):
    path = tmp_path / "world.yaml"
    path.write_text("format: handcart-world/1\nstart: {x_m: 0, y_m: 0}\n", encoding="utf-8")
    with make_backend("kinematic", load_robot("librarian"), path, seed=1) as backend:
        assert isinstance(backend, Backend)
        assert backend.name == "kinematic"
        backend.step()
    backend.close()


def test_an_unknown_name_is_told_with_the_nearest(tmp_path):
    assert "kinematic" in backend_names()
    with pytest.raises(UnknownBackend, match="did you mean 'kinematic'"):
        make_backend("kinematik", load_robot("librarian"), tmp_path, seed=0)
