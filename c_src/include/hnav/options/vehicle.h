/* Made by c_src/options/generate.py from vehicle.toml: change that, then ./run generate. */
#ifndef HNAV_OPTIONS_VEHICLE_H
#define HNAV_OPTIONS_VEHICLE_H

#include <stddef.h>
#include <stdint.h>

/* Kind of a vehicle. */
typedef enum hnav_vehicle_kind {
    HNAV_VEHICLE_CAR = 0,      /* stops, goes and turns as in a town, up to 15 m/s */
    HNAV_VEHICLE_AIRCRAFT = 1, /* 20 to 90 m/s, banks into its turns, climbs and sinks */
    HNAV_VEHICLE_SHIP = 2,     /* 2 to 9 m/s, in a swell */
    HNAV_VEHICLE_REST = 3,     /* stands on something that sways by millimetres */
    HNAV_VEHICLE_WAY = 4       /* passes through given points, points where it goes and does not bank */
} hnav_vehicle_kind;

/* Options of the simulated vehicle. How it moves follows from the kind and the seed: levels of speed, of turn and of bank,
 * each held for a random time.
 * Make them with hnav_vehicle_defaults, then change what you need; hnav_option("vehicle", i) states all this at run time. */
typedef struct hnav_vehicle_options {
    size_t size;    /* of this struct in bytes; set by hnav_vehicle_defaults */
    uint64_t stamp; /* the list and the version of the library that made it; set likewise */

    /* ------------------------ motion
     * What moves, and how. */

    /* car: stops, goes and turns; aircraft: banks into its turns; ship: slow in a swell; rest: stands; way: through given
     * points.
     * hnav_vehicle_kind, default car. The most usual. */
    int32_t kind;
    /* Heading at the start, clockwise from north.
     * [-2 pi, 2 pi] rad, default 0. North, with heading_unknown_rad any. */
    double heading_rad;
    /* The heading at the start is off by an angle drawn from seed, uniform within +- this.
     * [0, pi] rad, default pi. Filters are to find any heading. */
    double heading_unknown_rad;
    /* Factor on all that sways: roll and pitch of a car, the swell under a ship, the ground of a body at rest.
     * [0, 100], default 1. Sizes as usual for each kind; 0: nothing sways, and what rests stands still. */
    double sway;
    /* Vibration as of an engine that idles, 11 to 44 Hz: root mean square of the force ahead and of that along the
     * vertical, and as much turning about both horizontal axes as a metre away would give that.
     * [0, 100] m/s2, default 0. The motion alone; 0.2 is that of a car or a ship whose engine idles. */
    double vibration_m_s2;

    /* ------------------------ place
     * Where it starts, and the magnetic field there. */

    /* Latitude at the start.
     * [-pi/2, pi/2] rad, default 45 deg. Half way to the pole. */
    double latitude_rad;
    /* Longitude at the start.
     * [-pi, pi] rad, default 0. No place is special. */
    double longitude_rad;
    /* Height at the start, above the ellipsoid of WGS 84.
     * [-1e4, 1e5] m, default 50. A usual height of land. */
    double height_m;
    /* Strength of the magnetic field.
     * (0, 1] T, default 5e-5. A usual field of the Earth in middle latitudes. */
    double field_strength_tesla;
    /* Dip of the magnetic field below the horizon.
     * [-pi/2, pi/2] rad, default 60 deg. A usual dip in middle northern latitudes. */
    double field_dip_rad;
    /* Magnetic declination: the field points this much east of true north.
     * [-pi, pi] rad, default 0. True north is magnetic north. */
    double declination_rad;

    /* ------------------------ output
     * What rate and force are. */

    /* Rate and force are the means over so long before the instant, as sensors that integrate give them; 0: those of the
     * instant.
     * [0, 1] s, default 0. The truth of an instant. Give the period of an inertial sensor, else its samples stand for the
     * end of their interval alone. */
    double mean_over_s;

    /* ------------------------ chance
     * What is drawn at random. */

    /* Seed of the motion.
     * [0, 2147483647], default 0. Any seed is as good as any other. */
    int32_t seed;
} hnav_vehicle_options;

#endif /* HNAV_OPTIONS_VEHICLE_H */
