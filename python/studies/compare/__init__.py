"""Old against new, bit for bit: revision b991a70 and this checkout answer the same questions on the same machine.

    ./run study compare                     every scenario; exit status 1 on a difference that nobody declared
    ./run study compare --only 'c/ahrs/*'   some of them
    ./run study compare --list              their names
    ./run study compare --freeze            rewrites the stored answers of python_tests from the old build

Each side is a process of its own that drives C library, FMUs and Python of its checkout by drivers that know no more
than the headers, the option tables and the model descriptions of that side. Names that changed stand in hnav/renamed.csv,
differences that are meant, with their reasons, in exceptions.csv.
"""
