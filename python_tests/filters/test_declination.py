"""The declination by the World Magnetic Model, against the values that NOAA publishes with it."""

import math
import sys

import pytest

import hnav


# Of the reports of WMM2025 and WMM2020: height in km, latitude, longitude, year, declination in deg.
@pytest.mark.parametrize(
    "height_km, latitude, longitude, year, declination",
    [
        (0, 80, 0, 2025.0, 1.28),
        (0, 0, 120, 2025.0, -0.16),
        (0, -80, 240, 2025.0, 68.78),
        (100, 80, 0, 2025.0, 0.85),
        (100, -80, 240, 2027.5, 67.93),
        (0, 80, 0, 2027.5, 2.59),
        (0, 80, 0, 2020.0, -1.28),
        (0, -80, 240, 2020.0, 69.36),
    ],
)
def test_it_has_the_published_values(height_km, latitude, longitude, year, declination):
    pytest.importorskip("pygeomag")
    # An issue ends where the next begins: at that instant the next one serves.
    given = hnav.declination_rad(math.radians(latitude), math.radians(longitude), 1000 * height_km, year)
    assert math.degrees(given) == pytest.approx(declination, abs=0.0051)


@pytest.mark.parametrize(
    "place, year, says",
    [((0, 0), 2014.9, "covers 2015 to 2030"), ((0, 0), 2030.1, "2030"), ((2, 0), 2026, "latitude_rad = 2"),
     ((math.radians(-64.1), math.radians(135.9)), 2026, "no compass")],
)  # fmt: skip
def test_it_refuses_what_no_issue_serves(place, year, says):
    pytest.importorskip("pygeomag")
    with pytest.raises(hnav.HnavValueError, match=says):
        hnav.declination_rad(*place, 0, year)


def test_the_last_day_is_served_and_longitudes_go_round():
    pytest.importorskip("pygeomag")
    assert math.isfinite(hnav.declination_rad(0.8, 0.2, 0, 2030.0))
    assert hnav.declination_rad(0.8, 0.2 - 2 * math.pi, 0, 2026) == pytest.approx(
        hnav.declination_rad(0.8, 0.2, 0, 2026), abs=1e-9
    )


def test_without_the_package_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pygeomag", None)
    with pytest.raises(hnav.HnavRuntimeError, match="pip install pygeomag"):
        hnav.declination_rad(0, 0, 0, 2026)


PLACE = (math.radians(48.1), math.radians(11.6), 500.0, 2026.5)


def test_a_place_and_a_date_set_the_reference_field_and_the_declination():
    pytest.importorskip("pygeomag")
    options = hnav.Options("ahrs", place_and_date=PLACE)
    assert options.reference_mode == "given"
    assert options.reference_strength_tesla == pytest.approx(48.8e-6, abs=0.5e-6)
    assert math.degrees(options.reference_dip_rad) == pytest.approx(64.2, abs=0.5)
    assert options.declination_rad == hnav.declination_rad(*PLACE)
    assert hnav.Options("ahrs", place_and_date=PLACE, declination_rad=0.5).declination_rad == 0.5
    ins = hnav.Options("ins", place_and_date=PLACE)
    assert ins.declination_rad == options.declination_rad
    with pytest.raises(hnav.HnavValueError, match="place_and_date has 2 numbers: give latitude_rad, longitude_rad"):
        hnav.Options("ahrs", place_and_date=PLACE[:2])
