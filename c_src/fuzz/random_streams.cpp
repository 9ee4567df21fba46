// Filters with random options live through random streams of samples: motion and rest, gaps of a second to days, bursts of one
// stamp, late samples, readings beyond all sense, zeros and what is no number, commands, saves and loads. After every advance
// the promises of the API hold, and what was pushed adds up with what the filter says that it used and refused.
//
//     random_streams FIRST COUNT [STEP]   COUNT streams of seeds FIRST, FIRST + STEP, ...; the last line sums them up. A step of
//                                         9 (kinds) from 7 on: navigation alone; from 8 on: coloured errors alone
//
// A broken promise ends the program with its text; the last line before it names the seed.
#include "attitude.hpp"
#include "ins.hpp"
#include "ins_error.hpp"

#include <algorithm>
#include <array>
#include <random>

namespace {

class Random {
public:
    explicit Random(std::uint64_t seed) : engine_(seed) {}

    double uniform(double from, double to) { return from + (to - from) * std::uniform_real_distribution<double>()(engine_); }
    double normal() { return normal_(engine_); }
    bool once_in(int n) { return choice(n) == 0; }
    int choice(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
    // All sizes between are as likely.
    double log_uniform(double from, double to) { return from * std::pow(to / from, uniform(0, 1)); }

private:
    std::mt19937_64 engine_;
    std::normal_distribution<double> normal_;
};

struct Total {
    long calls = 0, accepted = 0, refused = 0, without_answer = 0, repaired = 0;
};

// ------------------------------------------------------------------------------------------------ attitude

// What a filter of options of one kind can be made with: a few rows changed to any value that their range allows.
template <class Options>
void change_options(Random& random, const char* list, Options* options) {
    int rows = 0;
    while (hnav_option(list, rows)) ++rows;
    for (int changes = random.choice(6); changes > 0; --changes) {
        const hnav_option_info* info = hnav_option(list, random.choice(rows));
        const bool real = info->kind == HNAV_OPTION_REAL;
        const double min = std::max(info->min, -1e3), max = std::min(info->max, real ? 1e3 : 64.0);
        for (int i = 0; i < info->count; ++i) {
            const double usual = hnav_option_value(info, options, i);
            const double near = usual * random.log_uniform(0.01, 100), any = random.uniform(min, max + (real ? 0 : 0.999));
            const double value = real && usual != 0 ? near : any;
            hnav_set_option_value(info, options, i, std::clamp(real ? value : std::floor(value), min, max));
        }
    }
}

class AttitudeStream {
public:
    AttitudeStream(std::uint64_t seed, Total* total) : random_(seed), total_(total) {
        options_.ahrs = seed % 2 == 0;
        options_.hrekf_options = hnav_hrekf_defaults(random_.once_in(4) ? HNAV_PRESET_PAPER : HNAV_PRESET_DEFAULT);
        options_.ahrs_options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
        if (random_.once_in(2)) change_options(random_, "ahrs", &options_.ahrs_options);
        if (random_.once_in(2)) change_options(random_, "hrekf", &options_.hrekf_options);
        // Every solver as often as any other, whatever the preset.
        options_.hrekf_options.solver = options_.ahrs_options.solver = static_cast<int>(seed / 2 % 4);
        hnav_status status;
        char message[256] = "";
        filter_ = options_.create(&status, message, sizeof message);
        fuzz::answered(status, message); // some options exclude each other
        HOLDS((filter_ != nullptr) == (status == HNAV_OK));
        t_s_ = random_.once_in(3) ? 1.7e9 : 0;
        length_ = 50 + random_.choice(400);
    }
    ~AttitudeStream() { hnav_filter_destroy(filter_); }
    AttitudeStream(const AttitudeStream&) = delete;

    void live() {
        if (!filter_) return;
        for (int k = 0; k < length_; ++k) {
            step_time();
            move();
            push();
            if (random_.once_in(60)) command();
            if (!random_.once_in(5)) advance();
        }
        const auto s = diagnostics();
        total_->repaired += static_cast<long>(s.covariance_repaired);
        fuzz::resets(filter_, options_);
    }

private:
    // What the filter is to have counted.
    struct Counts {
        std::array<std::uint64_t, 4> accepted{};
        std::uint64_t late = 0, non_finite = 0, zero = 0;
        bool dropped = false; // an event without an answer takes its samples with it
    };

    void step_time() {
        switch (random_.choice(40)) {
        case 0: t_s_ += random_.log_uniform(0.1, 1e5); break;
        case 1: burst_ = random_.choice(20); break;
        default: t_s_ += burst_ > 0 ? 0 : random_.uniform(0.005, 0.015);
        }
        if (burst_ > 0) --burst_;
    }

    void move() {
        if (random_.once_in(50)) speed_ = random_.once_in(3) ? 0 : random_.log_uniform(0.01, 30);
        for (double& v : rate_) v = 0.98 * v + 0.2 * speed_ * random_.normal();
        for (int i = 0; i < 3; ++i) force_[i] = (i == 2 ? -9.8 : 0) + 0.3 * speed_ * random_.normal();
        const double field[3] = {2e-5, 1e-6, 4.3e-5};
        for (int i = 0; i < 3; ++i) field_[i] = field[i] + 1e-6 * random_.normal();
    }

    // A reading, now and then beyond what a sensor can give.
    void spoil(double* v) {
        if (!random_.once_in(30)) return;
        const double infinity = std::numeric_limits<double>::infinity();
        const double values[] = {0, NAN, infinity, -infinity, 1e7, -1e6, 1e5, 1e3, -50, 1e-20, 1e-300};
        const double value = values[random_.choice(11)];
        if (random_.once_in(2)) v[random_.choice(3)] = value;
        else std::fill(v, v + 3, value);
    }

    void push() {
        spoil(copy_of(rate_));
        const double t_s = random_.once_in(15) ? t_s_ - random_.log_uniform(1e-3, 10) : random_.once_in(300) ? NAN : t_s_;
        if (!random_.once_in(10)) note(HNAV_SENSOR_GYRO, hnav_filter_push_gyro(filter_, t_s, value_));
        spoil(copy_of(force_));
        if (!random_.once_in(10)) note(HNAV_SENSOR_ACCEL, hnav_filter_push_accel(filter_, t_s, value_));
        spoil(copy_of(field_));
        if (random_.once_in(3)) note(HNAV_SENSOR_MAG, hnav_filter_push_mag(filter_, t_s, value_));
        if (random_.once_in(20)) note(HNAV_SENSOR_HEADING, hnav_filter_push_heading(filter_, t_s, random_.uniform(-4, 4), 0.1));
        if (random_.once_in(200)) note(HNAV_SENSOR_HEADING, hnav_filter_push_heading(filter_, t_s, 1, -0.1));
    }

    double* copy_of(const double* v) {
        std::copy(v, v + 3, value_);
        return value_;
    }

    void note(int sensor, hnav_status status) {
        ++total_->calls;
        fuzz::answered(status, hnav_filter_message(filter_));
        ++(status == HNAV_OK ? total_->accepted : total_->refused);
        counts_.accepted[static_cast<std::size_t>(sensor)] += status == HNAV_OK;
        counts_.late += status == HNAV_ERROR_LATE_SAMPLE;
        counts_.non_finite += status == HNAV_ERROR_NON_FINITE || status == HNAV_ERROR_OUT_OF_RANGE;
        counts_.zero += status == HNAV_ERROR_ZERO_VECTOR;
    }

    void advance() {
        const double ahead = random_.once_in(3) ? random_.log_uniform(1e-3, random_.once_in(20) ? 1e5 : 0.1) : 0;
        const hnav_status status = hnav_filter_advance(filter_, t_s_ + ahead);
        t_s_ += ahead;
        ++total_->calls;
        fuzz::answered(status, hnav_filter_message(filter_));
        HOLDS(status == HNAV_OK || status == HNAV_ERROR_SOLVER);
        total_->without_answer += status == HNAV_ERROR_SOLVER;
        counts_.dropped = counts_.dropped || status == HNAV_ERROR_SOLVER;
        fuzz::look(filter_);
        adds_up();
    }

    hnav_diagnostics diagnostics() const {
        auto s = hnav_sized<hnav_diagnostics>();
        HOLDS(hnav_filter_diagnostics(filter_, &s) == HNAV_OK);
        return s;
    }

    void adds_up() const {
        const auto s = diagnostics();
        HOLDS(s.late == counts_.late && s.non_finite == counts_.non_finite && s.zero == counts_.zero);
        auto h = hnav_sized<hnav_health>();
        HOLDS(hnav_filter_health(filter_, &h) == HNAV_OK);
        for (std::size_t i = 0; i < 4; ++i) {
            const std::uint64_t seen = s.used[i] + h.sensor[i].left_out;
            HOLDS(counts_.dropped || s.waiting > 0 ? seen <= counts_.accepted[i] : seen == counts_.accepted[i]);
            HOLDS(h.sensor[i].late <= s.late && h.sensor[i].state >= HNAV_SENSOR_STATE_OK &&
                  h.sensor[i].state <= HNAV_SENSOR_STATE_MISSING);
        }
    }

    void command() {
        switch (random_.choice(4)) {
        case 0: HOLDS(hnav_filter_realign(filter_) == HNAV_OK); break;
        case 1:
            HOLDS(hnav_filter_reset(filter_) == HNAV_OK);
            counts_ = {};
            break;
        case 2:
            state_ = fuzz::saved(filter_);
            saved_counts_ = counts_;
            saved_t_s_ = t_s_;
            break;
        default:
            if (state_.empty()) return;
            HOLDS(hnav_filter_load(filter_, state_.data(), state_.size()) == HNAV_OK);
            HOLDS(fuzz::saved(filter_) == state_);
            counts_ = saved_counts_;
            t_s_ = saved_t_s_;
        }
        fuzz::look(filter_);
    }

    Random random_;
    Total* total_;
    fuzz::Options options_;
    hnav_filter* filter_ = nullptr;
    double t_s_ = 0, saved_t_s_ = 0, speed_ = 1;
    int length_ = 0, burst_ = 0;
    double rate_[3] = {}, force_[3] = {}, field_[3] = {}, value_[3] = {};
    Counts counts_, saved_counts_;
    std::vector<unsigned char> state_;
};

// ------------------------------------------------------------------------------------------------ INS

class InsStream {
public:
    InsStream(std::uint64_t seed, Total* total) : random_(seed), total_(total) {
        hnav_ins_options options = hnav_ins_defaults(static_cast<hnav_ins_preset>(random_.choice(4)));
        if (random_.once_in(2)) change_options(random_, "ins", &options);
        char message[256] = "";
        const hnav_status made = hnav_ins_create(&filter_, &options, message, sizeof message);
        fuzz::answered(made, message); // some options exclude each other
        HOLDS((filter_ != nullptr) == (made == HNAV_OK));
        length_ = 500 + random_.choice(5000);
    }
    ~InsStream() { hnav_filter_destroy(filter_); }
    InsStream(const InsStream&) = delete;

    void live() {
        for (int k = 0; filter_ && k < length_; ++k) {
            const bool leaps = random_.once_in(500);
            t_s_ += leaps ? random_.log_uniform(0.1, 1e5) : random_.uniform(0.005, 0.015);
            move();
            push_imu();
            if (random_.once_in(10)) push_fix();
            if (random_.once_in(40)) push_aid();
            if (random_.once_in(400)) command();
            if (random_.once_in(3)) advance();
        }
    }

private:
    void move() {
        if (random_.once_in(200)) speed_ = random_.once_in(3) ? 0 : random_.log_uniform(0.1, 300);
        if (random_.once_in(300)) turn_ = random_.once_in(2) ? 0 : random_.uniform(-1, 1);
        north_m_ += 0.01 * speed_;
    }
    double spoilt(double value) {
        if (!random_.once_in(400)) return value;
        const double any[] = {0, NAN, std::numeric_limits<double>::infinity(), 1e7, -1e6, 1e3, 60, 1e-300};
        return any[random_.choice(8)];
    }
    double stamp() { return random_.once_in(300) ? t_s_ + random_.uniform(-20, 20) : t_s_; }
    void push_imu() {
        if (random_.once_in(1000)) away_ = random_.choice(1000);
        if (away_ > 0 && --away_ > 0) return;
        double rate[3], force[3];
        for (int i = 0; i < 3; ++i) {
            rate[i] = spoilt((i == 2 ? turn_ : 0) + 0.01 * random_.normal());
            force[i] = spoilt((i == 2 ? -9.8 : i == 1 ? speed_ * turn_ : 0) + 0.1 * random_.normal());
        }
        note(hnav_filter_push_imu(filter_, stamp(), rate, force));
    }
    double sigma() { return random_.once_in(50) ? random_.log_uniform(1e-6, 1e5) : 1; }
    void push_fix() {
        double velocity[3] = {spoilt(speed_ + 0.1 * random_.normal()), spoilt(0.1 * random_.normal()), spoilt(0)};
        const double sigmas[3] = {0.1 * sigma(), 0.1 * sigma(), 0.1 * sigma()};
        note(hnav_filter_push_velocity(filter_, stamp(), velocity, sigmas));
        const double of[3] = {sigma(), sigma(), sigma()}, far = random_.once_in(100) ? random_.log_uniform(1e-5, 1) : 0;
        note(hnav_filter_push_position(filter_, stamp(), spoilt(0.8 + far + north_m_ / 6.4e6), spoilt(0.2), spoilt(100), of));
    }
    void push_aid() {
        switch (random_.choice(4)) {
        case 0: note(hnav_filter_push_heading(filter_, stamp(), random_.uniform(-4, 4), 0.1 * sigma())); break;
        case 1: note(hnav_filter_push_speed(filter_, stamp(), spoilt(speed_), 0.1 * sigma())); break;
        case 2: note(hnav_filter_push_pressure(filter_, stamp(), spoilt(1e5), 10 * sigma())); break;
        default: {
            const double field[3] = {spoilt(2e-5), spoilt(1e-6), spoilt(4.3e-5)};
            note(hnav_filter_push_mag(filter_, stamp(), field));
        }
        }
    }
    void note(hnav_status status) {
        ++total_->calls;
        fuzz::answered(status, hnav_filter_message(filter_));
        ++(status == HNAV_OK ? total_->accepted : total_->refused);
    }
    void advance() {
        const hnav_status status = hnav_filter_advance(filter_, t_s_);
        ++total_->calls;
        fuzz::answered(status, hnav_filter_message(filter_));
        HOLDS(status == HNAV_OK || status == HNAV_ERROR_SOLVER);
        total_->without_answer += status == HNAV_ERROR_SOLVER;
        fuzz::look_at_ins(filter_);
    }
    void command() {
        switch (random_.choice(3)) {
        case 0: HOLDS(hnav_filter_reset(filter_) == HNAV_OK); break;
        case 1:
            state_ = fuzz::saved(filter_);
            saved_t_s_ = t_s_;
            break;
        default:
            if (state_.empty()) return;
            HOLDS(hnav_filter_load(filter_, state_.data(), state_.size()) == HNAV_OK);
            t_s_ = saved_t_s_;
        }
    }

    Random random_;
    Total* total_;
    hnav_filter* filter_ = nullptr;
    double t_s_ = 0, saved_t_s_ = 0, speed_ = 10, turn_ = 0, north_m_ = 0;
    int length_ = 0, away_ = 0;
    std::vector<unsigned char> state_;
};

// ------------------------------------------------------------------------------------------------ INS errors

void live_with_ins_errors(std::uint64_t seed, Total* total) {
    Random random(seed);
    const fuzz::InsErrorModel model;
    hnav_ins_error_options options = hnav_ins_error_defaults();
    options.form = random.choice(5);
    const bool printed = options.form == HNAV_INS_ERROR_MDKF || options.form == HNAV_INS_ERROR_AMDKF;
    if (printed) options.joseph = 0;
    else options.noise_scaling = random.choice(5);
    options.window = 1 + random.choice(20);
    hnav_ins_error_filter* filter = nullptr;
    char message[256] = "";
    const hnav_status made = hnav_ins_error_filter_create(&filter, &options, &model.view, message, sizeof message);
    fuzz::answered(made, message); // some options exclude each other
    HOLDS((filter != nullptr) == (made == HNAV_OK));
    std::vector<unsigned char> state;
    for (int k = 0; filter && k < 300; ++k) {
        const double u = random.normal();
        double z[2] = {random.normal(), random.normal()};
        if (random.once_in(30)) z[random.choice(2)] *= random.log_uniform(10, 1e30);
        if (random.once_in(60)) z[random.choice(2)] = NAN;
        const std::uint8_t present[2] = {!random.once_in(10), !random.once_in(10)};
        const hnav_status status = hnav_ins_error_filter_step(filter, &u, z, present);
        fuzz::answered(status, hnav_ins_error_filter_message(filter));
        ++total->calls;
        ++(status == HNAV_OK ? total->accepted : total->refused);
        if (random.once_in(50)) state = fuzz::saved(filter);
        if (random.once_in(50) && !state.empty())
            HOLDS(hnav_ins_error_filter_load(filter, state.data(), state.size()) == HNAV_OK);
        if (random.once_in(100)) HOLDS(hnav_ins_error_filter_reset(filter) == HNAV_OK);
        fuzz::look(filter, printed);
    }
    hnav_ins_error_filter_destroy(filter);
}

} // namespace

int main(int count, char** arguments) {
    constexpr std::uint64_t kinds = 9;
    const std::uint64_t first = count > 1 ? std::strtoull(arguments[1], nullptr, 10) : 0;
    const std::uint64_t streams = count > 2 ? std::strtoull(arguments[2], nullptr, 10) : 0;
    const std::uint64_t step = count > 3 ? std::strtoull(arguments[3], nullptr, 10) : 1;
    if (streams == 0 || step == 0) {
        std::fprintf(stderr, "random_streams FIRST COUNT [STEP]: COUNT seeds from FIRST on, at least one\n");
        return 2;
    }
    Total total;
    for (std::uint64_t seed = first; seed < first + step * streams; seed += step) {
        std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
        std::fflush(stdout);
        if (seed % kinds == 8) live_with_ins_errors(seed, &total);
        else if (seed % kinds == 7) InsStream(seed, &total).live();
        else AttitudeStream(seed, &total).live();
    }
    std::printf(
        "%llu streams, %ld calls: %ld samples used, %ld refused; %ld advances without an answer, %ld covariances repaired\n",
        static_cast<unsigned long long>(streams), total.calls, total.accepted, total.refused, total.without_answer,
        total.repaired);
    return 0;
}
