"""The answers of this checkout and those of another revision, bit for bit.

    ./run study compare                        with d7bc172, which is built once: all scenarios
    ./run study compare REVISION --only 'ins/*' --json moved.json

One line a scenario: equal, or which columns moved. Both sides are asked through doors whose words stay: the command line and the
FMUs, each in a process of its own with its own library.
"""
