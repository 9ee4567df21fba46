// A plant of an FMU in this process, in a list of all of them.
#pragma once

#include "observer/plan.hpp"

#include <cstdint>

namespace hnav::observer {

class LivePlant {
public:
    // Its trajectory as a single instance; see live_plants.cpp.
    struct Way {
        const Plan* plan = nullptr;
        double start_s = 0;
        double* answers = nullptr;
        int count = 0;
    };

    LivePlant() = default;
    LivePlant(const LivePlant&) = delete;
    LivePlant& operator=(const LivePlant&) = delete;
    ~LivePlant();

    // Takes ownership of the stored trajectory.
    void enter(std::uint64_t token, const Way& way);
    static bool lives(std::uint64_t token);
    // Instances with this token do not disturb each other; valid while one of them exists.
    static void pass(std::uint64_t token);
    static bool has_passed(std::uint64_t token);
    // A copy of the trajectory of a plant with this token, its plan to plan: empty if there is none, or no memory.
    static Way way_of(std::uint64_t token, Plan* plan);

private:
    std::uint64_t token_ = 0;
    bool listed_ = false, passed_ = false;
    Way way_;
    LivePlant* next_ = nullptr;
};

} // namespace hnav::observer
