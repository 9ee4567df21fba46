"""Spellings of units: dps, deg.s^-1, °/s, rad s⁻¹, m/(s^2), µT. pint would read g as gram and grad as gon."""

from __future__ import annotations

import re
import unicodedata

from hnav.units import COUNTED, SI_PER

DEGREES = dict.fromkeys("°º˚", "deg")  # the second and third look like the first
MINUS = dict.fromkeys("−‐‑–", "-")
SYMBOLS = str.maketrans({**DEGREES, **MINUS, "μ": "u", "ʯ": "u", "µ": "u", "⁄": "/", "∕": "/", "⋅": "", "·": ""})
LEFT_AWAY = str.maketrans(dict.fromkeys(" ^*_()[]{}.\"'", ""))
WORDS = (
    (re.compile(r"squared|quadrat"), "2"), (re.compile(r"micro-?"), "u"), (re.compile(r"milli-?(?!s)"), "m"), (re.compile(r"nano-?(?!s)"), "n"),
    (re.compile(r"met(?:er|re)s?"), "m"), (re.compile(r"seconds?|secs?|sek"), "s"), (re.compile(r"minutes?"), "min"),
    (re.compile(r"hours?|hrs?"), "h"), (re.compile(r"radians?"), "rad"), (re.compile(r"degrees?|degs(?=/)|grados?|gradi|graden|grad"), "deg"),
    (re.compile(r"revolutions?|rotations?|turns?|umdrehungen"), "rev"), (re.compile(r"teslas?"), "t"), (re.compile(r"per|pro"), "/"),
)  # fmt: skip


def words_in(name: str) -> list[str]:
    """Those of a name of a column, in lower case: accX_raw2 is acc, x, raw2."""
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+\d*|[A-Z]+\d*(?![a-z])|\d+", name)]


def words_of(text: str) -> frozenset[str]:
    """Those of a list, parted by blanks."""
    return frozenset(text.split())


BEHIND_BRACKETS = re.compile(r"(.*?)\s*[\(\[]((?:[^()\[\]]|\([^()]*\))*)[\)\]]\s*")
"""IMU_ATTI(0):accelX[meters/Sec2], Accelerometer (z) [m/(s^2)]: a name, and the last brackets, which may hold its unit."""
PER_TIME = re.compile(r"/|per|s *\^?[-−⁻]|dps|rpm")


def _of_rate(*bases: str) -> str:
    """Spellings of a unit of angle by second; an angle alone is a rate too, where a gyroscope says it."""
    return " ".join(f"{base} {base}/s {base}s {base}s-1 {base}s1 {base}ps {base}/1s" for base in bases)


_SPELLED = {
    "gyro": {"rad/s": _of_rate("rad", "r"), "deg/s": _of_rate("deg", "d") + " dps", "mdeg/s": _of_rate("mdeg") + " mdps", "mrad/s": _of_rate("mrad"),
             "rpm": "rpm rev/min u/min revmin-1", "rev/s": "rev/s revs-1 rps revps", "deg/h": "deg/h degh-1 dph degh"},
    "accel": {"m/s2": "m/s2 ms-2 ms2 mps2 m/s/s mss m/ss ms-1s-1 mps/s n/kg", "g": "g gn gs g0 gee gees gravity gforce standardgravity",
              "mg": "mg mgs", "cm/s2": "cm/s2 cms-2 cms2 gal", "mm/s2": "mm/s2 mms-2 mms2", "ft/s2": "ft/s2 fts-2"},
    "mag": {"T": "t", "uT": "ut", "nT": "nt", "G": "g gs ga gauss", "mG": "mg mgauss mga", "mT": "mt",
            "au": "au arb arbitrary arbitraryunit arbitraryunits localflux normalized normalised"},
    "time": {"s": "s", "ms": "ms msec millis mseconds", "ns": "ns nsec nanos", "us": "us usec micros", "min": "min mins", "h": "h"},
}  # fmt: skip
SPELLED = {quantity: {w: unit for unit, words in units.items() for w in words.split()} for quantity, units in _SPELLED.items()}
for _quantity in SPELLED:
    SPELLED[_quantity].pop("r", None)
    SPELLED[_quantity].pop("d", None)  # alone these name an axis or nothing

COUNTS = words_of("lsb lsbs samples frames count counts cnt cnts raw adc digit digits ticks int16 i16 code codes")


def spelled_unit(quantity: str, text: str) -> str | None:
    """The unit of gyro, accel, mag or time that a text names, if it does."""
    squeezed = unicodedata.normalize("NFKC", text.translate(SYMBOLS)).translate(SYMBOLS).casefold().translate(LEFT_AWAY)
    if found := SPELLED[quantity].get(squeezed):
        return found
    return SPELLED[quantity].get(abbreviated(squeezed))


def abbreviated(text: str) -> str:
    """Words of units in lower case as their signs: meters/sec is m/s."""
    for pattern, short in WORDS:
        text = pattern.sub(short, text)
    return text


def asked_unit(quantity: str, text: str) -> str | None:
    """The unit that a caller asks for: one of SI_PER, however it is spelled, or so many of it, as 1/131 deg/s."""
    if text in SI_PER[quantity]:
        return text
    match = COUNTED.fullmatch(text.strip())
    spelled = spelled_unit(quantity, match.group(3) if match else text)
    if spelled is None or (match and float(match.group(2) or 1) == 0):
        return None
    return f"{match.group(1)}{'/' + match.group(2) if match.group(2) else ''} {spelled}" if match else spelled


def only_sensor_of(text: str) -> str | None:
    """The sensor whose unit a text names and no other's: deg/s is of a gyroscope, but deg may be an angle, and G is g or gauss."""
    found = [sensor for sensor in ("gyro", "accel", "mag") if spelled_unit(sensor, text)]
    return found[0] if len(found) == 1 and (found != ["gyro"] or PER_TIME.search(text.lower())) else None


def is_unit(text: str) -> bool:
    """Whether a text names a unit of gyro, accel, mag or time."""
    return any(spelled_unit(quantity, text) for quantity in SPELLED)


def is_counts(text: str) -> bool:
    """Whether a text says that numbers are those of the chip."""
    return bool(COUNTS & set(re.findall(r"[a-z]+\d*", text.lower())))


def may_be_unit(text: str) -> bool:
    """Whether a text in brackets is meant as a unit: a short word, or one with a sign that units have; descriptions are longer."""
    text = text.strip()
    return bool(text) and (
        bool(re.search(r"[/^²°º⁻]|s-\d", text)) or is_counts(text) or re.fullmatch(r"[^\W\d_]{1,5}", text) is not None
    )


def unknown_unit(quantity: str, name: str, text: str) -> str:
    """The error text for a column with an unknown unit."""
    if is_counts(text) and quantity != "time":
        example = {
            "gyro": "'1/131 deg/s' (MPU-6050, ICM-20948 at 250 deg/s; 1/16.4 at 2000; LSM6 8.75 mdeg/s at 250; BMI160 1/131.2 at 250)",
            "accel": "'1/16384 g' (most chips at 2 g; 1/2048 at 16 g; LSM6 0.061 mg at 2 g)",
            "mag": "'0.15 uT' (AK8963, AK09916; HMC5883L 0.92 mG)",
        }[quantity]
        return f"the column {name} holds counts of the chip ({text}): say what one of them is, such as {quantity}_unit={example}"
    cure = f"give {quantity}_unit={' or '.join(tuple(SI_PER[quantity])[:3])}{', or rate_hz' if quantity == 'time' else ''}"
    return f"the unit {text!r} of the column {name} is not supported: {cure}"
