// Made by c_src/options/generate.py from shared.toml: change that, then ./run generate.
#pragma once

#include "options/lists.hpp"

// clang-format off
namespace hnav {

inline constexpr const char* body_names[] = {text("any"), text("hand"), text("walker"), text("car"), text("ship"), text("quadrotor"), text("aircraft")};
inline constexpr const char* body_meanings[] = {
    text("nothing is assumed"), text("held or worn, and turned about: the velocity returns to zero within a second"),
    text("worn by a person or an animal that walks, also on a foot"), text("a vehicle on wheels or tracks"),
    text("a ship or a boat"), text("a multirotor that hovers and flies slowly; a helicopter that cruises is an aircraft"),
    text("an aeroplane, or a helicopter that cruises"),
};
inline constexpr const char* gyro_hold_names[] = {text("forward"), text("backward"), text("instant")};
inline constexpr const char* gyro_hold_meanings[] = {
    text("the rate sampled at t_k acts on [t_k, t_k+1): causal, every engine agrees"),
    text("it acts on (t_k-1, t_k]: recordings of integrating gyros"),
    text("it was read at t_k: mean of two samples between them"),
};
inline constexpr const char* reference_mode_names[] = {text("learnt"), text("given")};
inline constexpr const char* reference_mode_meanings[] = {
    text("strength and dip of the field from the samples of the start"), text("reference_strength_tesla and reference_dip_rad"),
};
inline constexpr const char* gamma_mode_names[] = {text("off"), text("fixed"), text("relative"), text("kl")};
inline constexpr const char* gamma_mode_meanings[] = {
    text("gamma infinite: the hybrid extended Kalman filter (HEKF)"), text("the paper's constant gamma"),
    text("1/gamma^2 = rho / lmax(L P L'), rho = 1 - exp(-rate T)"),
    text("from a tolerance on relative entropy (Levy and Nikoukhah 2013)"),
};
inline constexpr const char* start_mode_names[] = {text("triad"), text("attitude"), text("heading")};
inline constexpr const char* start_mode_meanings[] = {
    text("tilt from force, heading from field (or from a heading sample if that comes first)"),
    text("start_q_nb, at the first sample"), text("tilt from force, heading start_heading_rad"),
};
inline constexpr const char* navigation_frame_names[] = {text("ned"), text("enu")};
inline constexpr const char* navigation_frame_meanings[] = {
    text("north, east, down"), text("east, north, up"),
};
inline constexpr const char* solver_names[] = {text("erkstep"), text("adams"), text("closed_form"), text("euler")};
inline constexpr const char* solver_meanings[] = {
    text("SUNDIALS ARKODE, Dormand-Prince 5(4)"), text("SUNDIALS CVODE, Adams-Moulton, fixed-point iteration"),
    text("exact for a held rate"), text("the paper's: forward Euler in sub-steps of euler_step_s"),
};

} // namespace hnav
