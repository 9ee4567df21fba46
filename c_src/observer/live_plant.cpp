#include "observer/live_plant.hpp"

#include "base/memory.hpp"
#include "base/spin_lock.hpp"

#include <algorithm>

namespace hnav::observer {
namespace {

SpinLock guard;
LivePlant* first = nullptr;

} // namespace

LivePlant::~LivePlant() {
    const SpinLock::Held held(guard);
    release_block(way_.answers);
    if (!listed_) return;
    LivePlant** at = &first;
    while (*at != this) at = &(*at)->next_;
    *at = next_;
}

void LivePlant::enter(std::uint64_t token, const Way& way) {
    const SpinLock::Held held(guard);
    token_ = token;
    way_ = way;
    passed_ = false;
    for (const LivePlant* one = first; one; one = one->next_) passed_ |= one->token_ == token && one->passed_;
    next_ = first;
    first = this;
    listed_ = true;
}

bool LivePlant::lives(std::uint64_t token) {
    const SpinLock::Held held(guard);
    for (const LivePlant* one = first; one; one = one->next_)
        if (one->token_ == token) return true;
    return false;
}

void LivePlant::pass(std::uint64_t token) {
    const SpinLock::Held held(guard);
    for (LivePlant* one = first; one; one = one->next_) one->passed_ |= one->token_ == token;
}

bool LivePlant::has_passed(std::uint64_t token) {
    const SpinLock::Held held(guard);
    for (const LivePlant* one = first; one; one = one->next_)
        if (one->token_ == token && one->passed_) return true;
    return false;
}

LivePlant::Way LivePlant::way_of(std::uint64_t token, Plan* plan) {
    const SpinLock::Held held(guard);
    for (const LivePlant* one = first; one; one = one->next_) {
        if (one->token_ != token || !one->way_.answers) continue;
        if (!plan->copy(*one->way_.plan)) return {};
        Way way{plan, one->way_.start_s, static_cast<double*>(take_block(one->way_.count * sizeof(double))), one->way_.count};
        if (way.answers) std::copy_n(one->way_.answers, way.count, way.answers);
        return way;
    }
    return {};
}

} // namespace hnav::observer
