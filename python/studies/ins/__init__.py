"""Does the navigation filter find its heading from any start, and does it say so only then? Simulated starts with exact truth.

    ./run study ins --starts 200 [--kinds car,aircraft,ship] [--grade industrial] [--workers 2] [--seed 1]
    ./run study ins --help       other bodies and conditions, and what else is measured: tilt, north, wheels, hindsight, a flight, hands

Every start has a random place, heading, motion, sensors and satellites, whose stamps have an unknown latency of up to 0.1 s and of
whose fixes one of a hundred lies far off. A start is false when, at the first instant of heading_ready, the error of the heading
exceeds both 3 sigma and 5 deg. z2 is the mean of the squared normalised errors, 1 when they are as large as stated. What a start may
meet stands in studies.ins.conditions, the rules that --without leaves out in studies.ins.rules, motions in studies.ins.motions.
"""
