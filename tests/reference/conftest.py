from collections.abc import Iterator

import numpy as np
import pytest


@pytest.fixture(autouse=True)
def _no_silent_arithmetic() -> Iterator[None]:
    with np.errstate(all="raise"):
        yield
