"""Units by name, as what one of them is in SI."""

from math import pi

G_M_S2 = 9.80665
"""Standard gravity: what accelerometers that say g mean."""

RAD_S_PER = {"rad/s": 1.0, "deg/s": pi / 180, "mdeg/s": pi / 180e3}
"""Of a rate."""

M_S2_PER = {"m/s2": 1.0, "g": G_M_S2, "mg": 1e-3 * G_M_S2}
"""Of a force, that is, force by mass."""

TESLA_PER = {"T": 1.0, "uT": 1e-6, "nT": 1e-9, "G": 1e-4, "mG": 1e-7, "au": 5e-5}
"""Of a magnetic field. au: arbitrary; the filter learns the strength anyway."""

S_PER = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
"""Of a time."""

SI_PER = {"gyro": RAD_S_PER, "accel": M_S2_PER, "mag": TESLA_PER, "time": S_PER}
"""By what is measured; the first unit of each is the SI one."""
