"""The measurements of docs/results: their commands, and what they say."""

from __future__ import annotations

from typing import NamedTuple

TRIALS, FLIGHT = "DIR", "FLIGHT"
FOLDERS = {TRIALS: "BROAD_DIR", FLIGHT: "HNAV_FLIGHT"}
"""Words of a command that stand for a folder, and the variable of the environment that names it."""


class Section(NamedTuple):
    """A measurement. command: as it is typed behind ./run; quick: within two minutes on two cores."""

    title: str
    says: str
    command: str
    quick: bool

    @property
    def needs(self) -> list[str]:
        """Variables of the environment."""
        return [FOLDERS[word] for word in self.command.split() if word in FOLDERS]


SECTIONS = {
    "broad": Section(
        "Recordings: all filters",
        "Root mean square errors on the 14 BROAD trials that we have (Laidig et al., Data 6(7):72, 2021), every filter with its "
        "defaults. In sample for ours: the default presets were found on these trials. ekf-larger-q is the hrekf without its "
        "robust law, with a bias walk a hundred times as large: where the walk was chosen, that harms.",
        f"study bench {TRIALS} --sets BROAD",
        True,
    ),
    "stress": Section(
        "Recordings made harder",
        "The same trials begun in motion, with a field that is false at first, with samples lost, late and jittering; "
        "`python -m pydoc studies.bench.stress` says what was done to them. Samples that are lost, late or jittering cost the AHRS 10 % at "
        "most, bursts of silence 31 %: how a fast hand turns in a tenth of a second without gyroscope is not in the other samples. Where the "
        "field is false at a start at rest, the smoother is worse than the filter.",
        f"study bench {TRIALS} --sets CROP,XREST,XMOT,DROP,JITTER,LATE,BURST",
        False,
    ),
    "hrekf": Section(
        "Recordings: the HREKF with rates held backward",
        "Integrating gyroscopes give the mean rate of the interval before a sample.",
        f"hnav score {TRIALS} --filter hrekf --set gyro_hold=backward",
        True,
    ),
    "sensitivity": Section(
        "Recordings: how much hangs on a parameter",
        "Each parameter of the AHRS times and divided by 1.3, one at a time.",
        f"study sensitivity {TRIALS}",
        True,
    ),
    "readiness": Section(
        "Heading ready, and wrong",
        "Simulated starts with exact truth: how often the first heading_ready comes with an error beyond 3 sigma and 5 deg.",
        "study readiness --starts 9000",
        False,
    ),
    "hidden": Section(
        "Heading ready: what cannot be known",
        "The same with fields that look like a true one from inside: false and steady from the beginning, false and slowly growing, iron of "
        "15 % of the field fixed to the body.",
        "study readiness --hidden --starts 240",
        True,
    ),
    "readiness_errors": Section(
        "Heading ready: sensors with every error",
        "The same starts with sensors that have also a bias of the accelerometer and errors of scale of the gyroscope, as large as the options "
        "of the AHRS say. The sigma of heading allows for them, for the iron of a room and for a hand that drifts to and fro, which these starts "
        "have not: no single one of them makes it wide, without one of them it is a tenth to a half narrower.",
        "study readiness --every-error --starts 1200",
        False,
    ),
    "readiness_told": Section(
        "Heading ready: told that the errors are not there",
        "The starts of the first of these tables once more, by a filter that is told what they are made of: no iron in the place, a hand that only "
        "swings, no bias of the accelerometer and no errors of scale. The sigma of heading is then of the size of the errors.",
        "study readiness --starts 1200 --set local_declination_rad=1e-6 --set mag_azimuth_noise_per_sqrt_hz=0.0018 "
        "--set mag_intensity_noise_per_sqrt_hz=0.00125 --set reference_walk_per_sqrt_s=3e-4 --set velocity_noise_m_s_per_sqrt_hz=0.05 "
        "--set gyro_noise_rad_per_sqrt_s=2.3e-4 --set start_sigma_accel_bias_m_s2=1e-4 --set gyro_rate_noise_sqrt_s=1e-4 "
        "--set gyro_bias_walk_rad_s_per_sqrt_s=1e-6 --set start_sigma_gyro_scale=1e-5 --set start_sigma_gyro_misalignment_rad=1e-5",
        False,
    ),
    "readiness_clean": Section(
        "Heading ready: told that the field is clean",
        "The same by a filter that is told of the field alone: no iron in the place, from the first sample on. Nothing that estimates how "
        "disturbed the field is can make the sigma of heading in a clean field narrower than this. What is left stands for the gyroscope, the "
        "accelerometer and the motion, and these starts have less of their errors than the AHRS allows for.",
        "study readiness --starts 1200 --set local_declination_rad=1e-6 --set mag_azimuth_noise_per_sqrt_hz=0.0018 "
        "--set mag_intensity_noise_per_sqrt_hz=0.00125 --set reference_walk_per_sqrt_s=3e-4",
        False,
    ),
    "ins": Section(
        "Navigation from any heading",
        "Simulated starts with exact truth, industrial sensors, coloured satellites with outliers and a latency that nobody tells: when "
        "the heading was ready, how often falsely (error above 3 sigma and 5 deg), and the end after 150 s. A ship turns too slowly for "
        "most of its starts to be ready by then.",
        "study ins --starts 3000 --seed 7",
        False,
    ),
    "ins_consumer": Section(
        "Navigation from any heading: consumer",
        "The same with chips of phones and hobby; straight and take_off gain speed straight ahead when they are switched on, a quadrotor "
        "hovers with up to 3 m/s2 of noise, a walker holds a telephone with fixes once a second, whose slow errors of 3 m the filter is told. Where it hardly accelerates a body of this "
        "grade does not find its heading to 1 deg within its 1 to 2 minutes, and says so.",
        "study ins --starts 200 --seed 3 --grade consumer --kinds car,aircraft,straight,take_off,quadrotor,walker",
        False,
    ),
    "ins_magnetometer": Section(
        "Navigation with a magnetometer",
        "Starts with chips of phones and hobby, without a magnetometer and with one that nobody has calibrated and whose declination nobody tells: "
        "hard iron of up to one and a half times the horizontal field, soft iron of 3 %, steel beside the way, for one start in four half a "
        "minute in a false field of the size of the true one.",
        "study ins --magnetometer --starts 200 --seed 3 --grade consumer --kinds car,aircraft,ship,quadrotor,walker",
        False,
    ),
    "ins_faults": Section(
        "Faults while navigating",
        "One fault each, 90 s after the start: how often it was told (fixes gated, or a flag of readiness fell), the share of instants from its "
        "begin to a minute after its end at which the error lies within 3 sigma, and the largest error of the position.",
        "study ins --faults --starts 8 --seed 3",
        False,
    ),
    "ins_hindsight": Section(
        "Navigation with hindsight",
        "Filter and smoother over the same starts, half a minute without satellites from 90 s on: rms of the rows from before the filter knew "
        "the heading, of those from then on, and of ten seconds in the middle of the outage; z2 is the mean of the squared normalised errors.",
        "study ins --smooth --starts 100 --seed 3",
        False,
    ),
    "ins_wheels": Section(
        "Cars without satellites",
        "Simulated cars of consumer grade that lose the satellites: without wheels, with "
        "the speed of wheels where and when the filter takes them to be, and as they are in a car that nobody has measured.",
        "study ins --wheels --grade consumer --starts 100 --seed 9",
        False,
    ),
    "ins_flight": Section(
        "A recorded flight",
        "A small aeroplane, consumer preset, switched on in the air with nothing known of its heading: the difference from the heading of its own "
        "filter. Its turns tell by how much its rows are stamped later than the gyroscopes. In circles of 30 deg/s a latency of the satellites "
        "that nobody reckons with turns the heading by its angle.",
        f"study ins --flight {FLIGHT}",
        True,
    ),
    "ins_hands": Section(
        "Recorded hands",
        "BROAD's trials in which a hand moves the sensor about, without a magnetometer but for the last row: minutes that begin every 20 s with nothing known of the "
        "heading, optical positions with noise for fixes, and velocities of 0.1 m/s from them; the difference of the heading from the optics. "
        "Until the hand moves there is nothing to know. Smoothed are those whose heading was found, sigma 4 deg.",
        f"study ins --hands {TRIALS}",
        True,
    ),
    "ins_north": Section(
        "North by the rate of the Earth",
        "Bodies that stand and are told where, for ten minutes: on a base that sways by millimetres (rest) or by a centimetre (swaying, its filter "
        "told so), that vibrates by 0.2 m/s2, and at 80 degrees of latitude (polar); the others stand at 45. The bias of a gyroscope over the "
        "rate of the Earth along the horizontal is the least error there can be; the white noise of the gyroscopes adds to it.",
        "study ins --gyrocompass --starts 200",
        False,
    ),
    "navigation": Section(
        "Navigation in closed loop",
        "Monte Carlo over the systems of FMUs, any heading at the start, industrial grade: what the scenarios are stands in "
        "[models/systems/navigation](../models/systems/navigation/README.md). z2 is the mean of squared errors over their variance, 1 when "
        "sigmas are right. 30 runs leave it uncertain by a fifth, and all scenarios meet the same draws of sensors and satellites, so that theirs lie "
        "off 1 together.",
        "hnav montecarlo navigation --runs 30 --scenarios nominal,outage_30,outage_60,jump,late_200ms,ship,aircraft_turn,pole,date_line "
        "--out build/navigation.parquet",
        False,
    ),
    "gyrocompass": Section(
        "North at rest in closed loop",
        "The same for a body at rest that is told its place: a navigation grade on a base that sways by millimetres and on a still one, at 80 "
        "degrees of latitude, and a tactical grade. All four meet the same draws of biases, of which 30 leave z2 uncertain by a quarter; 200 "
        "stand in the section before. The place is told without error, and its z2 is 0.",
        "hnav montecarlo gyrocompass --runs 30 --scenarios nominal,still,latitude_80,tactical --out build/gyrocompass.parquet",
        False,
    ),
    "observer": Section(
        "The observer: are its sigmas right",
        "Runs with known truth, plants as functions in Python, as Reference FMUs and as a room made by CasADi (HNAV_PLANTS). Those with events "
        "stand beside 5000 particles on the same samples, which is what is possible; the rms is that of speed, rate and temperature. "
        "1 is right of NEES/n and NIS.",
        "study observer --part errors --runs 50",
        False,
    ),
    "observer_laws": Section(
        "The observer beside what is known",
        "Single figures: means and sigmas beside a Kalman filter and beside 20 000 true states after a bounce and under a ceiling that half of them "
        "reach; a parameter that is learnt, in 100 runs; NIS over 2000 s of van der Pol's oscillator with mu = 1000, through two jumps.",
        "study observer --part laws",
        True,
    ),
    "observer_cost": Section(
        "The observer: cost of a sample",
        "Two states, derivatives given, all in C; the difference of the last two cases is what a bounce costs. Instructions depend on the compiler "
        "alone; CPU time on the machine too.",
        "study observer --part cost",
        True,
    ),
    "thermal_box": Section(
        "The observer finds opened lids",
        "Simulated recordings of a heated box whose lid is opened for minutes (`python -m pydoc studies.thermal_box` says what the truth has and "
        "the model has not): the conductance of the box is a parameter that may wander, noises are tuned first.",
        "study thermal_box",
        False,
    ),
    "speed": Section(
        "Cost of a sample beside VQF and Fusion",
        "All in C or C++ with equal outputs, over 70 s of BROAD trial 07 at 286 Hz. Instructions depend on the compiler alone; "
        "CPU time on the machine too.",
        "study speed",
        False,
    ),
    "ins_speed": Section(
        "Cost of a sample of the navigation filter",
        "28 errors, and ten numbers that flow, over a simulated car at 100 Hz with five fixes of position and of velocity a second, from any heading, its start "
        "included; corrections come ten times a second. Estimates are computed when they are asked for.",
        "study ins_speed",
        True,
    ),
    "small": Section(
        "The small build on a Cortex-M4F",
        "AHRS and HREKF by their closed forms in memory of the caller's, beside VQF and Fusion, over 60 s of BROAD trial 07 in qemu. "
        "Code is that of a program which only filters, with all that it calls; the last column is the largest angle to the same "
        "filter in double precision on this machine (Fusion: in single).",
        "study small",
        False,
    ),
    "robust": Section(
        "What the robust law and the adaptation are worth",
        "Simulated, 20 seeds; in each scenario one thing is other than told. The adaptation is experimental.",
        "study robust",
        False,
    ),
    "convergence": Section(
        "How soon a wrong start is corrected",
        "Time from which the attitude error stays below 3 deg for a second, over the heading error of the start and the sigma that the filter claims "
        "for it, beside filters of the literature; median, worst, and the share that does not get there within 20 s.",
        "study convergence --seeds 60",
        False,
    ),
    "table1": Section(
        "The paper's Table 1",
        "Closed co-simulation, 200 seeds. P0 and rho of the fitted regime were searched for until the paper's ratios came back. There an "
        "EKF with a larger Q has the smallest errors of all; with an honest P0 the EKF as told has.",
        "study table1 --runs 200",
        False,
    ),
    "scenarios": Section(
        "Scenarios of the turntable",
        "Closed co-simulation, 60 seeds each; what the scenarios are stands in "
        "[models/systems/turntable](../models/systems/turntable/README.md). Under gyro drift the HREKF does better than the HEKF, and an EKF "
        "with a larger Q as well, with a sigma that is right; with outliers, and where the filter is told the truth, the EKF as told does best "
        "of the three.",
        "study scenarios --runs 60 --workers 2",
        False,
    ),
    "faults": Section(
        "Faults: what a few seconds cost",
        "A simulated body held in a hand, exact truth, 100 runs of each event: seconds from the event's end until the tilt, or the "
        "heading where the field is at fault, stays within 5 deg; beside it a complementary filter of 3 s. Ready and false: samples "
        "from the event's begin to 60 s after its end that are called ready with an error beyond 5 sigma and 5 deg.",
        "study faults --seeds 100 --part events",
        False,
    ),
    "damaged": Section(
        "Faults: recordings damaged on purpose",
        "BROAD trials 3, 9, 15 and 29, each with one fault (`python -m pydoc studies.faults.recordings`). VQF is given the true rate "
        "and rows that are lost put back. What the gyroscope did not see is lost to every filter: there sigma has to say so.",
        f"study faults {TRIALS} --part recordings",
        True,
    ),
    "interrupted": Section(
        "Interrupted commands",
        "simulate, filter, montecarlo and report, each killed 100 times while it overwrites an older output, half of the times while "
        "it writes, and ten times on a full and on a read-only disk. A montecarlo is killed again half of the times, then run to its end.",
        "study interrupted --kills 100",
        False,
    ),
    "coloured": Section(
        "Coloured INS errors",
        "1000 flights of the F-4C; the oracle is told the noise of every step.",
        "study ins_error_table --runs 1000",
        False,
    ),
    "coloured_fitted": Section(
        "Coloured INS errors: noise fitted to the order of the paper",
        "The same with 26 numbers of noise, interval and time constant that were searched for until AMDKF over MDKF had the order of the paper's "
        "Table 1 on all eight channels. It shows that such flights exist, not that the paper's were like this.",
        "study ins_error_table --runs 400 --fitted",
        False,
    ),
    "coloured_faults": Section(
        "Coloured INS errors: every kind of fault",
        "300 flights of the F-4C in each case, nine filters on one model; the oracle is told the noise of each channel and nothing else. "
        "`python -m pydoc studies.ins_error_faults` says more.",
        "study ins_error_faults --runs 300 --seed 20260202",
        False,
    ),
    "coloured_settings": Section(
        "Coloured INS errors, random settings",
        "100 random settings of noise, interval and time constant, 60 flights each.",
        "study ins_error_table --runs 60 --settings 100",
        False,
    ),
    "coloured_time": Section(
        "Coloured INS errors: time of a step",
        "The augmented filter beside filterpy on the same model and samples; filterpy adapts nothing.",
        "study ins_error_peer",
        True,
    ),
    "calibration": Section(
        "Calibration: stated and true error",
        "Simulated recordings; covered: the share of those answered whose error over the whole sphere is at most the stated one. Nine of "
        "ten are promised.",
        "study calibration",
        True,
    ),
    "certificate": Section(
        "Certificate of the paper's experiment",
        "R = 1e-2, Q = 1e-6, the corrections after 15 s.",
        "hnav certify --experiment turntable --preset paper --set gamma_mode=off",
        True,
    ),
    "certificate_field": Section(
        "Certificate with a field of 10 Hz",
        "Force at 100 Hz, every tenth sample of the field: windows of ten corrections have to contract. Four minutes of processor time.",
        "hnav certify --experiment turntable --preset paper --set gamma_mode=off --field-every 10",
        False,
    ),
    "certificate_lost": Section(
        "Certificate with lost samples",
        "1 % of the samples of force and of field are lost, each by itself.",
        "hnav certify --experiment turntable --preset paper --set gamma_mode=off --lost 0.01",
        False,
    ),
    "certificate_slow": Section(
        "Certificate at 4 Hz",
        "The filter itself gets force and field every 25 T; beside it the longest interval above, where gains are frozen, says little.",
        "hnav certify --experiment turntable --preset paper --set gamma_mode=off --force-every 25 --field-every 25",
        True,
    ),
    "certificate_rho": Section(
        "Certificate with rho = 0.1",
        "Noise may leave the region, so it is not certified.",
        "hnav certify --experiment turntable --preset paper --set gamma_mode=relative --set gamma_relative_rate_1_s=10.536 --duration 25",
        True,
    ),
    "streams": Section(
        "Random streams under the sanitizers",
        "Random options, every solver, both attitude filters and the INS error filter; gaps, bursts, late and impossible samples; "
        "`python -m pydoc studies.streams` says more.",
        "study streams --streams 10000",
        False,
    ),
    "mutants": Section(
        "Mutants: would the tests notice",
        "Small changes of the C++ sources, one at a time: an operator, a constant, a condition, a call left out, chosen by a hash from "
        "all that a parser finds. Killed: a C++ test, or a quick law in Python, fails with it. Equivalent: no test can tell it from "
        "the original; why, stands in python/studies/mutants/equivalent.csv. Those that live are listed. Tests were written for what this "
        "choice showed; before, at revision 37c890c, 118 of 146 were killed (81 %), so of another choice more will live than of this.",
        "study mutants",
        False,
    ),
    "growth": Section(
        "Growth",
        "Time and memory with the rows of a file, with filters side by side, with the age of late samples, with workers. At revision 510906b, "
        "before FMUs were kept from run to run, a run of the turntable took 2.0 to 2.1 s of a processor where it then took 0.55 to 0.59.\n\n"
        "![Time of a row and memory over the rows](images/growth_rows.png)\n"
        "![Time of a sample over the number of filters](images/growth_filters.png)\n"
        "![Cost of a late sample over its age](images/growth_late.png)\n"
        "![Runs a second](images/growth_montecarlo.png)",
        "study growth --pictures docs/images",
        False,
    ),
    "long": Section(
        "Thirty days",
        "Error and memory of every simulated day at 100 Hz, with stamps of today's clocks.",
        "study long --days 30",
        False,
    ),
}
