"""hnav's filters beside those of others, on BROAD trials as they are and made harder (see studies.bench.stress).

    ./run study bench DIR [--sets BROAD,CROP] [--filters ...] [--peers ...] [--csv FILE] [--picture FILE]

    rows = [row for rows in benchmark(recordings, contenders(["ahrs"], ["vqf"])[0], ["BROAD", "CROP"]) for row in rows]
    for line in summary(rows): ...

Scores are those of hnav.reports.scores. Times are medians over trials and repeats of the time per sample; within a trial
everybody runs in turn, so that whatever else the machine does hits all alike. What is timed is one call on whole
arrays; hnav's fills an attitude for each sample and nothing else (its sigmas cost as much again), VQF's what it always
fills. imufusion has no such call and is fed by a Python loop, ahrs is Python itself: their times are marked.
"""
