"""``--transport``: a stage of its slot, by the driver that has one."""

from __future__ import annotations

import pytest

import airlight as al
from airlight.app.build import _draw_arguments
from airlight.app.lights import parse_lights
from airlight.app.options import DrawOptions


def test_transport_chooses_the_driver():
    driver = _draw_arguments(DrawOptions(transport="translucent:angle_deg=60"))["driver"]
    assert driver == al.driver.HalfAngle(transport=al.transport.Translucent(angle_deg=60))
    told = _draw_arguments(DrawOptions(driver="half_angle:group=8,transport=coloured"))["driver"]
    assert told == al.driver.HalfAngle(group=8, transport="coloured")
    assert _draw_arguments(DrawOptions(driver="half_angle:group=8", transport="coloured"))["driver"] == told


def test_transport_of_other_drivers_is_refused():
    with pytest.raises(al.ValueRangeError, match="the driver march has none"):
        _draw_arguments(DrawOptions(driver="march", transport="opaque"))
    with pytest.raises(al.ValueRangeError, match=r"--transport.*coloured"):
        _draw_arguments(DrawOptions(transport="sticky"))


def test_spot_light():
    (light,) = parse_lights(["spot:position=[0,-9,0],target=[0,0,0],angle_deg=20"])
    assert light == al.Light.spot(position=(0, -9, 0), target=(0, 0, 0), angle_deg=20)
    with pytest.raises(al.ValueRangeError, match=r"--light.target"):
        parse_lights(["spot:position=[0,-9,0]"])
