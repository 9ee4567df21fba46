// Saved states of every object of the C API: an incomplete state, or one of another object, is never loaded.
#include "base/saved_state.hpp"
#include "hnav/hnav.h"
#include "hnav/simulation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace {

using Bytes = std::vector<unsigned char>;

// An object behind the calls that save and load it. step: changes it, so that a wrong load is visible.
struct Object {
    std::string name;
    std::shared_ptr<void> life;
    std::function<void()> step;
    std::function<hnav_status(size_t*)> size;
    std::function<hnav_status(void*, size_t)> save;
    std::function<hnav_status(const void*, size_t)> load;
    std::function<std::string()> message;

    Bytes saved() const {
        size_t bytes = 0;
        EXPECT_EQ(size(&bytes), HNAV_OK);
        Bytes buffer(bytes);
        EXPECT_EQ(save(buffer.data(), buffer.size()), HNAV_OK);
        return buffer;
    }
    hnav_status load_all(const Bytes& buffer) const { return load(buffer.data(), buffer.size()); }
};

Object filter_object(const std::string& name, hnav_filter* filter) {
    Object o;
    o.name = name;
    o.life.reset(filter, hnav_filter_destroy);
    o.step = [filter, k = 0]() mutable {
        const double t_s = 0.01 * k++;
        const double rate[3] = {0.1, std::sin(t_s), 0}, force[3] = {0.5, 0, -9.8}, field[3] = {2e-5, 0, 4e-5};
        EXPECT_EQ(hnav_filter_push_imu(filter, t_s, rate, force), HNAV_OK);
        EXPECT_EQ(hnav_filter_push_mag(filter, t_s, field), HNAV_OK);
        EXPECT_EQ(hnav_filter_advance(filter, t_s + 0.004), HNAV_OK);
    };
    o.size = [filter](size_t* n) { return hnav_filter_state_size(filter, n); };
    o.save = [filter](void* to, size_t n) { return hnav_filter_save(filter, to, n); };
    o.load = [filter](const void* from, size_t n) { return hnav_filter_load(filter, from, n); };
    o.message = [filter] { return hnav_filter_message(filter); };
    return o;
}

Object hrekf(double gate = 13.9) {
    hnav_hrekf_options options = hnav_hrekf_defaults(HNAV_PRESET_DEFAULT);
    options.queue_capacity = 4;
    options.mag_gate_nis = gate;
    hnav_filter* filter = nullptr;
    EXPECT_EQ(hnav_hrekf_create(&filter, &options, nullptr, 0), HNAV_OK);
    return filter_object("hrekf", filter);
}

Object ahrs(double trust_s = 60) {
    hnav_ahrs_options options = hnav_ahrs_defaults(HNAV_PRESET_DEFAULT);
    options.queue_capacity = 4;
    options.trust_s = trust_s;
    hnav_filter* filter = nullptr;
    EXPECT_EQ(hnav_ahrs_create(&filter, &options, nullptr, 0), HNAV_OK);
    return filter_object("ahrs", filter);
}

Object ins_error_filter(double A = 0.5) {
    static const double one = 1, half = 0.5;
    auto model = hnav_sized<hnav_ins_error_model>();
    model.nx = model.nz = 1;
    model.A = &A;
    model.H = model.Qw = model.Qv = model.QU = model.P0 = &one;
    model.An = &half;
    const hnav_ins_error_options options = hnav_ins_error_defaults();
    hnav_ins_error_filter* filter = nullptr;
    EXPECT_EQ(hnav_ins_error_filter_create(&filter, &options, &model, nullptr, 0), HNAV_OK);
    Object o;
    o.name = "ins_error_filter";
    o.life.reset(filter, hnav_ins_error_filter_destroy);
    o.step = [filter, k = 0]() mutable {
        const double z = std::sin(0.3 * k++);
        EXPECT_EQ(hnav_ins_error_filter_step(filter, nullptr, &z, nullptr), HNAV_OK);
    };
    o.size = [filter](size_t* n) { return hnav_ins_error_filter_state_size(filter, n); };
    o.save = [filter](void* to, size_t n) { return hnav_ins_error_filter_save(filter, to, n); };
    o.load = [filter](const void* from, size_t n) { return hnav_ins_error_filter_load(filter, from, n); };
    o.message = [filter] { return hnav_ins_error_filter_message(filter); };
    return o;
}

Object aircraft(uint64_t seed = 1) {
    static const double decay = -1, one = 1;
    auto model = hnav_sized<hnav_aircraft_model>();
    model.nx = 1;
    model.interval_s = 0.1;
    model.A_1_s = &decay;
    model.process_noise_per_sqrt_s = model.measurement_sigma = model.start_sigma = &one;
    hnav_aircraft_options options = hnav_aircraft_defaults();
    options.seed = seed;
    hnav_aircraft* plant = nullptr;
    EXPECT_EQ(hnav_aircraft_create(&plant, &options, &model, nullptr, 0), HNAV_OK);
    Object o;
    o.name = "aircraft";
    o.life.reset(plant, hnav_aircraft_destroy);
    o.step = [plant] { EXPECT_EQ(hnav_aircraft_step(plant, nullptr), HNAV_OK); };
    o.size = [plant](size_t* n) { return hnav_aircraft_state_size(plant, n); };
    o.save = [plant](void* to, size_t n) { return hnav_aircraft_save(plant, to, n); };
    o.load = [plant](const void* from, size_t n) { return hnav_aircraft_load(plant, from, n); };
    o.message = [plant] { return hnav_aircraft_message(plant); };
    return o;
}

Object imu_mag_sensor(int seed = 1) {
    hnav_imu_mag_sensor_options options = hnav_imu_mag_sensor_defaults();
    options.seed = seed;
    options.gyro.noise_deg_per_sqrt_h = options.gyro.bias_instability_rad_s = 1;
    options.mag.latency_s = 0.05;
    hnav_imu_mag_sensor* sensor = nullptr;
    EXPECT_EQ(hnav_imu_mag_sensor_create(&sensor, &options, 0, nullptr, 0), HNAV_OK);
    Object o;
    o.name = "imu_mag_sensor";
    o.life.reset(sensor, hnav_imu_mag_sensor_destroy);
    o.step = [sensor, k = 0]() mutable {
        auto truth = hnav_sized<hnav_truth>();
        truth.q_nb[0] = 1;
        truth.field_b_tesla[0] = 2e-5;
        EXPECT_EQ(hnav_imu_mag_sensor_sample(sensor, 0.01 * k, &truth), HNAV_OK);
        EXPECT_EQ(hnav_imu_mag_sensor_advance(sensor, 0.01 * k++), HNAV_OK);
    };
    o.size = [sensor](size_t* n) { return hnav_imu_mag_sensor_state_size(sensor, n); };
    o.save = [sensor](void* to, size_t n) { return hnav_imu_mag_sensor_save(sensor, to, n); };
    o.load = [sensor](const void* from, size_t n) { return hnav_imu_mag_sensor_load(sensor, from, n); };
    o.message = [sensor] { return hnav_imu_mag_sensor_message(sensor); };
    return o;
}

Object aid_sensor(int seed = 1) {
    hnav_aid_sensor_options options = hnav_aid_sensor_defaults();
    options.seed = seed;
    options.gnss.period_s = 0.01;
    options.gnss.latency_s = 0.05;
    hnav_aid_sensor* sensor = nullptr;
    EXPECT_EQ(hnav_aid_sensor_create(&sensor, HNAV_AID_GNSS, &options, 0, nullptr, 0), HNAV_OK);
    Object o;
    o.name = "aid_sensor";
    o.life.reset(sensor, hnav_aid_sensor_destroy);
    o.step = [sensor, k = 0]() mutable {
        auto truth = hnav_sized<hnav_vehicle_truth>();
        truth.q_nb[0] = 1;
        EXPECT_EQ(hnav_aid_sensor_sample(sensor, 0.01 * k, &truth), HNAV_OK);
        EXPECT_EQ(hnav_aid_sensor_advance(sensor, 0.01 * k++), HNAV_OK);
    };
    o.size = [sensor](size_t* n) { return hnav_aid_sensor_state_size(sensor, n); };
    o.save = [sensor](void* to, size_t n) { return hnav_aid_sensor_save(sensor, to, n); };
    o.load = [sensor](const void* from, size_t n) { return hnav_aid_sensor_load(sensor, from, n); };
    o.message = [sensor] { return hnav_aid_sensor_message(sensor); };
    return o;
}

std::vector<Object> objects() { return {hrekf(), ahrs(), ins_error_filter(), aircraft(), imu_mag_sensor(), aid_sensor()}; }

// The same objects with one option or number of the model changed.
std::vector<Object> relatives() {
    return {hrekf(20), ahrs(61), ins_error_filter(0.6), aircraft(2), imu_mag_sensor(2), aid_sensor(2)};
}

} // namespace

TEST(SavedStates, EveryFlippedBitIsRefusedAndChangesNothing) {
    for (Object& object : objects()) {
        for (int k = 0; k < 20; ++k) object.step();
        const Bytes whole = object.saved();
        Bytes damaged = whole;
        for (std::size_t bit = 0; bit < 8 * damaged.size(); ++bit) {
            const auto mask = static_cast<unsigned char>(1u << bit % 8);
            damaged[bit / 8] ^= mask;
            ASSERT_EQ(object.load_all(damaged), HNAV_ERROR_STATE_CORRUPT) << object.name << ", bit " << bit;
            damaged[bit / 8] ^= mask;
        }
        EXPECT_NE(object.message().find("damaged"), std::string::npos) << object.message();
        EXPECT_EQ(object.saved(), whole) << object.name;
        EXPECT_EQ(object.load_all(whole), HNAV_OK) << object.name;
        EXPECT_EQ(object.saved(), whole) << object.name;
    }
}

TEST(SavedStates, ThoseOfAnotherModelOrOtherOptionsAreSaidToBeWhole) {
    std::vector<Object> others = relatives();
    int i = 0;
    for (Object& object : objects()) {
        const Object& other = others[i++];
        object.step();
        const Bytes whole = object.saved();
        EXPECT_EQ(other.load_all(whole), HNAV_ERROR_STATE_CORRUPT) << object.name;
        EXPECT_NE(other.message().find("whole"), std::string::npos) << other.message();
    }
}

TEST(SavedStates, OtherSizesAreAnsweredAsSuch) {
    for (Object& object : objects()) {
        Bytes buffer = object.saved();
        EXPECT_EQ(object.save(buffer.data(), buffer.size() - 1), HNAV_ERROR_SIZE) << object.name;
        EXPECT_EQ(object.load(buffer.data(), buffer.size() - 8), HNAV_ERROR_SIZE) << object.name;
        EXPECT_EQ(object.load(buffer.data(), 0), HNAV_ERROR_SIZE) << object.name;
        EXPECT_NE(object.message().find("0 bytes"), std::string::npos) << object.message();
    }
}

TEST(SavedStates, ThoseOfALaterVersionAreAnsweredAsOfAnotherVersion) {
    for (Object& object : objects()) {
        Bytes buffer = object.saved();
        std::uint64_t kind;
        std::memcpy(&kind, buffer.data(), sizeof kind);
        for (const std::size_t more : {0, 8}) {
            buffer.resize(buffer.size() + more);
            const std::size_t numbers_bytes = buffer.size() - (hnav::SavedState::numbers(buffer.data()) - buffer.data());
            hnav::SavedState{kind, 99, 1, numbers_bytes}.seal(buffer.data());
            EXPECT_EQ(object.load_all(buffer), HNAV_ERROR_STATE_VERSION) << object.name;
            EXPECT_NE(object.message().find(hnav_version()), std::string::npos) << object.message();
        }
    }
}

// The first bytes and the sizes of states saved by hnav 0.1.0: of the filters with a queue of 64 instants, of the others with
// one state.
TEST(SavedStates, ThoseOfVersion01AreAnsweredAsOfAnotherVersion) {
    const struct {
        unsigned char start[8];
        std::size_t size;
    } old[] = {{{0x48, 0x4e, 0x41, 0x56, 0x30, 0x31, 0x90, 0x07}, 11256},  // hrekf
               {{0x48, 0x4e, 0x41, 0x56, 0x30, 0x31, 0x28, 0x0d}, 14120},  // ahrs, named aligner then
               {{0x68, 0x6e, 0x61, 0x76, 0x63, 0x6f, 0x6c, 0x00}, 192},    // INS error filter
               {{0x68, 0x6e, 0x61, 0x76, 0x63, 0x72, 0x00, 0x00}, 1312},   // aircraft
               {{0x48, 0x4e, 0x41, 0x56, 0x49, 0x4d, 0x53, 0x31}, 8656}};  // inertial and magnetic sensor
    std::vector<Object> present = objects(); // those added later are at the end
    for (std::size_t i = 0; i < std::size(old); ++i) {
        Bytes buffer(old[i].size);
        std::copy(std::begin(old[i].start), std::end(old[i].start), buffer.begin());
        EXPECT_EQ(present[i].load_all(buffer), HNAV_ERROR_STATE_VERSION) << present[i].name;
        // A size that fits by chance does not make them "damaged".
        buffer.resize(present[i].saved().size());
        EXPECT_EQ(present[i].load_all(buffer), HNAV_ERROR_STATE_VERSION) << present[i].name;
    }
}
