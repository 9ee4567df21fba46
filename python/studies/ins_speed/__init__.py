"""Time and instructions of a sample of the navigation filter: 28 errors, 10 numbers that flow, 100 Hz, five fixes a second.

    ./run study ins_speed

A simulated car from its start on, any heading, industrial sensors. CPU time is that of the thread, rounds of the integrators interleave;
instructions are counted where valgrind is.
"""
