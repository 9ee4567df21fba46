"""Cost of a sample in C and C++ beside VQF and Fusion, with equal outputs.

    ./run study speed

Thread CPU time, least and median of ten runs, and instructions where valgrind is there, over the first 20000 rows (70 s, 286 Hz)
of BROAD trial 07. The peers are built from the archives of their authors, with the compiler and -O3 that ours is built with.
"""
