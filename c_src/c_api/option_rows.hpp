// Words for writing option tables: a row is the field of the options struct, its unit, its range and its meaning.
// Include it once, after defining HNAV_OPTIONS as the name of the struct.
#include "c_api/option_table.hpp"

#include <cstddef>

namespace hnav {
namespace {

constexpr double pi = 3.14159265358979323846;

[[maybe_unused]] const char* const gyro_holds[] = {"forward", "backward"};
[[maybe_unused]] const char* const gamma_modes[] = {"off", "fixed", "relative", "kl"};
[[maybe_unused]] const char* const adaptations[] = {"off", "paper", "corrected"};
[[maybe_unused]] const char* const start_modes[] = {"triad", "attitude", "heading"};
[[maybe_unused]] const char* const reference_modes[] = {"learnt", "given"};
[[maybe_unused]] const char* const navigation_frames[] = {"ned", "enu"};
[[maybe_unused]] const char* const solvers[] = {"erkstep", "adams", "closed_form", "euler"};

} // namespace
} // namespace hnav

#define FIELD(name) #name
#define AT(name) offsetof(HNAV_OPTIONS, name)
// [min, max]
#define REAL(name, unit, min, max, count, text)                                                                                  \
    {FIELD(name), unit, text, nullptr, AT(name), min, max, count, 0, HNAV_OPTION_REAL, 0}
// (min, max]
#define ABOVE(name, unit, min, max, count, text)                                                                                 \
    {FIELD(name), unit, text, nullptr, AT(name), min, max, count, 0, HNAV_OPTION_REAL, 1}
#define INTEGER(name, min, max, text) {FIELD(name), "", text, nullptr, AT(name), min, max, 1, 0, HNAV_OPTION_INTEGER, 0}
#define CHOICE(name, list, text)                                                                                                 \
    {FIELD(name),        "", text, list, AT(name), 0, sizeof list / sizeof *list - 1, 1, sizeof list / sizeof *list,             \
     HNAV_OPTION_CHOICE, 0}

// Rows that filters share.
// Where the filter starts from.
#define START_ROWS                                                                                                               \
    REAL(start_q_nb, "", -2, 2, 4, "Attitude to start from, body to navigation, scalar first; normalised on use"),               \
        REAL(start_heading_rad, "rad", -2 * pi, 2 * pi, 1, "True heading of body x to start from, clockwise from north"),        \
        REAL(start_gyro_bias_rad_s, "rad/s", -10, 10, 3, "Gyro bias to start from"),                                             \
        ABOVE(start_sigma_tilt_rad, "rad", 0, 10, 1, "Standard deviation of the tilt at the start"),                             \
        ABOVE(start_sigma_heading_rad, "rad", 0, 10, 1, "Standard deviation of the heading at the start"),                       \
        ABOVE(start_sigma_bias_rad_s, "rad/s", 0, 10, 1, "Standard deviation of the gyro bias at the start")
// The magnetic field of the place.
#define REFERENCE_ROWS                                                                                                           \
    CHOICE(reference_mode, reference_modes,                                                                                      \
           "Strength and dip of the magnetic field: learnt from the samples of the start, or given"),                            \
        ABOVE(reference_strength_tesla, "T", 0, 1e6, 1, "Strength of the magnetic field, when given"),                           \
        REAL(reference_dip_rad, "rad", -pi / 2, pi / 2, 1, "Dip of the magnetic field below the horizon, when given")
// Navigation and body axes.
#define FRAME_ROWS                                                                                                               \
    CHOICE(navigation_frame, navigation_frames,                                                                                  \
           "Navigation frame of the outputs and of start_q_nb: north-east-down or east-north-up"),                               \
        REAL(declination_rad, "rad", -pi, pi, 1, "Magnetic declination: true heading = magnetic heading + declination"),         \
        REAL(q_body_sensor, "", -2, 2, 4, "Mounting: turns sensor vectors into the body frame, scalar first; normalised on use")
// Integrator, late samples, memory.
#define SOLVER_ROWS                                                                                                              \
    CHOICE(solver, solvers,                                                                                                      \
           "Integrator between events: SUNDIALS ERKStep, SUNDIALS CVODE Adams, closed form, or the paper's Euler"),              \
        REAL(solver_rtol, "", 1e-14, 1e-2, 1, "Relative tolerance of ERKStep and Adams"),                                        \
        REAL(solver_atol, "", 1e-20, 1e-2, 1,                                                                                    \
             "Absolute tolerance of ERKStep and Adams, relative to the nominal size of each state"),                             \
        ABOVE(euler_step_s, "s", 0, 1e3, 1, "Sub-step of Euler"),                                                                \
        REAL(horizon_s, "s", 0, 1e3, 1, "How much older than the newest used sample a sample may be"),                           \
        INTEGER(queue_capacity, 4, 1e6, "Instants that may wait or lie within the horizon")
