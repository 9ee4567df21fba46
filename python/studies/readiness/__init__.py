"""Does a filter say "heading ready" only when it is? Seeded starts of consumer-grade sensors with exact truth.

    ./run study readiness --starts 1000 [--filter ahrs] [--workers 2] [--csv FILE]

A start is wrong when, at the first instant of heading_ready, the true total error exceeds both 3 sigma (root sum of
squares of the three stated sigmas) and 5 deg. Every start has random sensors, a random attitude and a random field; the
groups are a kind of motion and a kind of magnetic disturbance, each equally often. Start i depends on the seed and i
alone, not on how many there are nor who computes them. With --hidden the fields are false in the ways that no filter can know:
steady from the beginning, slowly growing, and iron that is fixed to the body.

With --every-error the sensors have, beside noise, gyro bias and a late magnetometer, what the options of the AHRS allow for: a bias of
the accelerometer, errors of scale and misalignment of the gyroscope.

Beside it stands whether the sigma of heading is right: the mean of its squared normalised error at 5, 20 and 60 s.
"""
