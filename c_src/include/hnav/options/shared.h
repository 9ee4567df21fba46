/* Made by c_src/options/generate.py from shared.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_SHARED_H
#define HNAV_OPTIONS_SHARED_H

/* A set of defaults. */
typedef enum hnav_preset {
    HNAV_PRESET_DEFAULT = 0, /* real sensors, one setting for all */
    HNAV_PRESET_PAPER = 1    /* the source paper's Q and R, two Euler steps per sample at 100 Hz, P0 and gamma fitted */
} hnav_preset;

/* The interval on which a sampled rate acts. */
typedef enum hnav_gyro_hold {
    HNAV_GYRO_HOLD_FORWARD = 0,  /* the rate sampled at t_k acts on [t_k, t_k+1): causal, every engine agrees */
    HNAV_GYRO_HOLD_BACKWARD = 1, /* it acts on (t_k-1, t_k]: recordings of integrating gyros */
    HNAV_GYRO_HOLD_INSTANT = 2   /* it was read at t_k: mean of two samples between them */
} hnav_gyro_hold;

/* How the robust law finds its gamma. */
typedef enum hnav_gamma_mode {
    HNAV_GAMMA_OFF = 0,      /* gamma infinite: the hybrid extended Kalman filter (HEKF) */
    HNAV_GAMMA_FIXED = 1,    /* the paper's constant gamma */
    HNAV_GAMMA_RELATIVE = 2, /* 1/gamma^2 = rho / lmax(L P L'), rho = 1 - exp(-rate T) */
    HNAV_GAMMA_KL = 3        /* from a tolerance on relative entropy (Levy and Nikoukhah 2013) */
} hnav_gamma_mode;

/* Source of the first attitude. */
typedef enum hnav_start_mode {
    HNAV_START_TRIAD = 0,    /* tilt from force, heading from field (or from a heading sample if that comes first) */
    HNAV_START_ATTITUDE = 1, /* start_q_nb, at the first sample */
    HNAV_START_HEADING = 2   /* tilt from force, heading start_heading_rad */
} hnav_start_mode;

/* Source of the reference field. */
typedef enum hnav_reference_mode {
    HNAV_REFERENCE_LEARNT = 0, /* strength and dip of the field from the samples of the start */
    HNAV_REFERENCE_GIVEN = 1   /* reference_strength_tesla and reference_dip_rad */
} hnav_reference_mode;

/* Kind of body: the assumption about its motion. */
typedef enum hnav_body {
    HNAV_BODY_ANY = 0,       /* nothing is assumed */
    HNAV_BODY_HAND = 1,      /* held or worn, and turned about: the velocity returns to zero within a second */
    HNAV_BODY_WALKER = 2,    /* worn by a person or an animal that walks, also on a foot */
    HNAV_BODY_CAR = 3,       /* a vehicle on wheels or tracks */
    HNAV_BODY_SHIP = 4,      /* a ship or a boat */
    HNAV_BODY_QUADROTOR = 5, /* a multirotor that hovers and flies slowly; a helicopter that cruises is an aircraft */
    HNAV_BODY_AIRCRAFT = 6   /* an aeroplane, or a helicopter that cruises */
} hnav_body;

/* Navigation axes of attitudes. */
typedef enum hnav_navigation_frame {
    HNAV_FRAME_NED = 0, /* north, east, down */
    HNAV_FRAME_ENU = 1  /* east, north, up */
} hnav_navigation_frame;

/* Integrator between events. */
typedef enum hnav_solver {
    HNAV_SOLVER_ERKSTEP = 0,     /* SUNDIALS ARKODE, Dormand-Prince 5(4) */
    HNAV_SOLVER_ADAMS = 1,       /* SUNDIALS CVODE, Adams-Moulton, fixed-point iteration */
    HNAV_SOLVER_CLOSED_FORM = 2, /* exact for a held rate */
    HNAV_SOLVER_EULER = 3        /* the paper's: forward Euler in sub-steps of euler_step_s */
} hnav_solver;

#endif /* HNAV_OPTIONS_SHARED_H */
