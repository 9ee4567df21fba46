"""How time and memory grow: with the rows of a file, with filters side by side, with the age of late samples, with workers.

    ./run study growth [--part rows|filters|late|montecarlo] [--most-rows 1e7] [--pictures DIR]

Times are those of the processor, so that other work on the machine shows little.
With --pictures each part is drawn too.
"""
