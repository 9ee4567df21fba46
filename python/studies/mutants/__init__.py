"""Do the tests notice a fault in the code? Each mutant is one small change of a C++ source; a test has to fail.

    ./run mutants                          all of them: which were killed, by which test, which survive
    ./run mutants --only hybrid/           those of one folder or file
    ./run mutants --only ins --draw 1      30 others of a room

Sources of hybrid, attitude, maths and ins_error are copied to build/mutants, and every mutant is put behind a switch there:
the environment variable HMUT holds the number of the active mutant, so that all of them cost one build. A parser (tree-sitter)
finds the places that can be changed. The choice depends on a hash of the changed line, so that it stays when other lines
change. A first run of the tests without a mutant records which test reaches which mutant; only those are run with it.

Mutants that are equivalent to the original are listed with the reason in equivalent.csv.
"""
