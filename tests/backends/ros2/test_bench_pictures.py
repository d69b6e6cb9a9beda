"""Pictures of the bench are rendered only where they are read, and are those of the camera."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.capabilities.camera import Camera
from handcart.backends.ros2.bench.bench_messages import LatePicture

from .conftest import Make


def test_a_picture_is_rendered_once_it_is_read(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    rendered: list[int] = []
    render = LatePicture.__bytes__

    def counted(self: LatePicture) -> bytes:
        rendered.append(1)
        return render(self)

    monkeypatch.setattr(LatePicture, "__bytes__", counted)
    with make() as backend:
        camera = backend.get(Camera)  # type: ignore[type-abstract]
        assert camera is not None and backend.inner is not None
        for _ in range(3):
            backend.step()
        assert rendered == []
        first = camera.image()
        assert np.array_equal(first, camera.image()) and rendered == [1]
        there = backend.inner.get(Camera)  # type: ignore[type-abstract]
        assert there is not None and np.array_equal(first, there.image())
        backend.step()
        assert not np.array_equal(first, camera.image())


def test_a_kept_message_has_the_picture_of_its_own_time(make: Make) -> None:
    with make(faults=("delayed@camera/image_raw@0",)) as backend:
        camera = backend.get(Camera)  # type: ignore[type-abstract]
        assert camera is not None and backend.inner is not None
        there = backend.inner.get(Camera)  # type: ignore[type-abstract]
        assert there is not None
        taken = []
        for _ in range(14):
            backend.step()
            taken.append(there.image().copy())
        late = camera.image()
        assert any(np.array_equal(late, item) for item in taken[:-5])
