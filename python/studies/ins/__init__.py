"""Does the navigation filter find its heading from any start, and does it say so only then? Simulated starts with exact truth.

    ./run study ins --starts 200 [--kinds car,aircraft,ship,straight,take_off,quadrotor,walker] [--grade industrial] [--workers 2] [--seed 1]
    ./run study ins --gyrocompass --starts 200
    ./run study ins --tilt --starts 60
    ./run study ins --flight FOLDER
    ./run study ins --smooth --starts 100 [--kinds car,aircraft,ship] [--grade industrial]

Every start has a random place, heading, motion, sensors and satellites, whose stamps have an unknown latency of up to 0.1 s and of
whose fixes one of a hundred lies far off. A start is false when, at the first instant of heading_ready, the error of the
heading exceeds both 3 sigma and 5 deg. straight and take_off
stand or gain speed straight ahead when they are switched on, quadrotor hovers and vibrates, walker is a telephone with fixes once a second.

With --without RULE: the same with a copy of the library that lacks a rule of the search (studies/ins/rules.py): what the rule is worth.

With --conditions compass,first_fixes,state,noisy,wheels: starts with a compass that is 170 deg off, with first positions that are 300 m off
for two seconds, with a given state whose heading is 170 deg off, with satellites four times as noisy as they state, of cars with the speed of
their wheels.

With --magnetometer: each kind once more with an uncalibrated one and an unknown declination: hard iron of up to one and a
half times the horizontal field, soft iron, steel beside the way, for one start in four half a minute in a false field.

With --gyrocompass: bodies at rest with a given position and no aids: on a base that sways by millimetres (rest) or by a centimetre
(swaying, an option of their filters), that vibrates as beside an engine, and ten degrees from the pole (polar).

With --tilt: the squared normalised error of the tilt over the time, of trains, which stand, then gain speed and brake for up to a minute
each with few and wide bends, and of quadrotors that hover for up to a minute before they fly, by sensors of every grade.

With --smooth: what hindsight brings, in starts with half a minute without satellites from 90 s on. z2 is the mean of the squared
normalised errors, 1 when they are as large as stated.

With --flight: 28 starts in the air of the recording in FOLDER (thor75.csv and thor75_onboard.csv), judged by the aeroplane's own
filter from 60 to 90 s after the start; that filter is no truth, a part of the difference is its own.
"""
