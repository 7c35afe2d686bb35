"""Whether an adapter answers, for the set-up scripts: ``python -m airlight.app.setup_check`` ends with 0 when one does."""

from __future__ import annotations

import sys


def main() -> int:
    """Name the chosen adapter and return 0, or return 1."""
    from .. import api
    from ..errors import AirlightError

    try:
        chosen = [device for device in api.devices() if device.chosen]
    except AirlightError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    for device in chosen:
        print(f"adapter: {device.name} ({device.kind}, {device.backend})")
    return 0 if chosen else 1


if __name__ == "__main__":
    sys.exit(main())
