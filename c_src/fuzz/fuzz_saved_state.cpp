// Loading of saved states that were changed on the way: cut, bits turned, words swapped, or made up altogether. A filter
// refuses them and is as it was; if a filter accepts one, its numbers stay finite.
#include "attitude.hpp"
#include "ins_error.hpp"

#include <vector>

namespace {

using fuzz::Input;
using State = std::vector<unsigned char>;

// The change of a state, and whether it changed anything. Most are small: what a disk or a link does.
bool damage(Input& in, State& state) {
    const State before = state;
    for (int n = 1 + in.choice(8); n > 0; --n) {
        const std::size_t at = (in.byte() * 256u + in.byte()) % state.size();
        switch (in.choice(6)) {
        case 0: state[at] ^= static_cast<unsigned char>(1u << in.choice(8)); break;
        case 1: state[at] = in.byte(); break;
        case 2: // the sign of the number there: the damage that sums of words see least
            state[at | 7] ^= 0x80;
            break;
        case 3: {
            const double value = in.number();
            const std::size_t word = at / 8 * 8;
            if (word + 8 <= state.size()) std::memcpy(&state[word], &value, 8);
            break;
        }
        case 4: { // two words in each other's place
            const std::size_t word = at / 8 * 8, other = in.byte() * 8u % state.size();
            if (std::max(word, other) + 8 <= state.size())
                for (int i = 0; i < 8; ++i) std::swap(state[word + i], state[other + i]);
            break;
        }
        default:
            for (std::size_t i = at; i < state.size() && !in.end(); ++i) state[i] = in.byte();
            break;
        }
    }
    return state != before;
}

// Damage may write the letters of hnav 0.1 over the header; everything else keeps its answer.
bool is_right(hnav_status status, bool damaged, bool cut) {
    if (damaged && status == HNAV_ERROR_STATE_VERSION) return true;
    return status == (cut ? HNAV_ERROR_SIZE : damaged ? HNAV_ERROR_STATE_CORRUPT : HNAV_OK);
}

void attitude_filter(Input& in, int head) {
    fuzz::Options options;
    options.ahrs = head & 2;
    options.hrekf_options = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
    options.ahrs_options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    options.hrekf_options.queue_capacity = options.ahrs_options.queue_capacity = 8;
    options.hrekf_options.horizon_s = options.ahrs_options.horizon_s = 0.03;
    hnav_filter* filter = fuzz::make(options);
    HOLDS(filter);
    const int samples = in.choice(32);
    for (int k = 0; k < samples; ++k) {
        fuzz::push_good(filter, 0.01 * k);
        hnav_filter_advance(filter, 0.01 * k);
    }
    const State whole = fuzz::saved(filter);
    State other = whole;
    const bool damaged = damage(in, other);
    const std::size_t size = head & 4 ? in.byte() * 8u % (other.size() + 1) : other.size();
    const hnav_status status = hnav_filter_load(filter, other.data(), size);
    fuzz::answered(status, hnav_filter_message(filter));
    HOLDS(is_right(status, damaged, size != other.size()));
    HOLDS(fuzz::saved(filter) == whole);
    fuzz::look(filter);
    fuzz::takes_good_sample(filter, 0.01 * samples);
    HOLDS(hnav_filter_advance(filter, 0.01 * samples + 0.02) == HNAV_OK);
    hnav_filter_destroy(filter);
}

void ins_error_filter(Input& in, int head) {
    fuzz::InsErrorModel model;
    hnav_ins_error_options options = hnav_ins_error_defaults();
    options.form = in.choice(5);
    const bool printed = options.form == HNAV_INS_ERROR_MDKF || options.form == HNAV_INS_ERROR_AMDKF;
    if (printed) options.joseph = 0;
    if (options.form != HNAV_INS_ERROR_AUGMENTED) options.noise_scaling = HNAV_NOISE_SCALING_NONE;
    hnav_ins_error_filter* filter = nullptr;
    HOLDS(hnav_ins_error_filter_create(&filter, &options, &model.view, nullptr, 0) == HNAV_OK);
    const int steps = in.choice(32);
    const double u[1] = {0.1};
    for (int k = 0; k < steps; ++k) {
        const double z[2] = {std::sin(0.1 * k), 0.05 * k};
        HOLDS(hnav_ins_error_filter_step(filter, u, z, nullptr) == HNAV_OK);
    }
    const State whole = fuzz::saved(filter);
    State other = whole;
    const bool damaged = damage(in, other);
    const std::size_t size = head & 4 ? in.byte() * 8u % (other.size() + 1) : other.size();
    const hnav_status status = hnav_ins_error_filter_load(filter, other.data(), size);
    fuzz::answered(status, hnav_ins_error_filter_message(filter));
    HOLDS(is_right(status, damaged, size != other.size()));
    HOLDS(fuzz::saved(filter) == whole);
    const double z[2] = {0.1, 0.2};
    HOLDS(hnav_ins_error_filter_step(filter, u, z, nullptr) == HNAV_OK);
    fuzz::look(filter);
    hnav_ins_error_filter_destroy(filter);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    Input in(bytes, size);
    const int head = in.byte();
    if (head & 1) ins_error_filter(in, head);
    else attitude_filter(in, head);
    return 0;
}
