// The attitude filters behind hnav_filter: one class over Filter<Model> serves every attitude model. It turns the user's frames
// into the model's and back; the mathematics is the model's, the time is the filter's. The small build has its calls in part.
#pragma once

#include "attitude/common/estimate.hpp"
#include "attitude/common/frames.hpp"
#include "c_api/health.hpp"
#include "c_api/over_filter.hpp"
#include "c_api/shown_along.hpp"
#include "hnav/hnav.h"
#include "maths/scalar.hpp"
#include "signals/hold.hpp"

namespace hnav {

// The interface of attitude filters for any model. attitude.cpp implements the common calls.
struct EveryAttitude : hnav_filter {
    static constexpr Product of_product = Product::attitude;
    static constexpr const char* whom = "AHRS and HREKF";
    enum class At { shown, newest }; // the time of the last advance; just after the newest used event

    EveryAttitude() : hnav_filter(Product::attitude) {}

    Frames frames;
    int sensors = 0; // accepted by the model
    Hold hold = Hold::forward; // of the rate
    bool causal_only = false; // has inputs that act on the interval before them, and cannot apply them later
    bool in_callers_memory = false;

    hnav_status take(int sensor, double t_s, const double* value) final;
    hnav_status take_imu(double t_s, const double* rate, const double* force) final;
    hnav_status attitude(hnav_attitude* out) const final;
    hnav_status rate(double* rate_b) const final;
    hnav_status gyro_bias(double* bias_b, double* sigma) const final;
    hnav_status covariance(double* P) const final;
    hnav_status innovation(int sensor, hnav_innovation* out) const final;

    virtual void realign() = 0;

    virtual Outcome push(const AttitudeSample& sample) = 0;
    virtual bool has_room(int count) const = 0;
    virtual void count_refused(bool zero) = 0;

    virtual double newest_s() const = 0;
    virtual double stamp_of(double time_s) const = 0;
    virtual double late_limit_s() const = 0;
    virtual Estimate estimate(At) const = 0;
    virtual Vector3 rotation_variances(At) const = 0; // about the user's navigation axes
    virtual Vector3 bias_variances(At) const = 0;
    virtual ErrorCovariance error_covariance() const = 0;
    virtual const InnovationOf<Scalar>& last_innovation(int channel) const = 0;
    virtual FieldEstimate field_estimate() const = 0;
    virtual void gyro_calibration(double* S, double* sigma) const = 0;
    virtual hnav_sensor_health sensor_health(int channel) const = 0;

protected:
    ~EveryAttitude() = default; // not destroyed through the base: see destroy()
};

// Not in the small build: whole recordings, and a caller's integrator.
struct WholeAttitude : EveryAttitude {
    // For smoothing: continues from the newest state with time reversed, the next sample at t_s.
    virtual bool turns_back() const = 0;
    virtual void turn_back(double t_s) = 0;
    virtual void prefer_closed_form(bool prefer) = 0;

    // A row of a recording as one event; false: nothing was taken, the samples must be pushed separately.
    virtual bool push_event(const AttitudeEvent& event) = 0;
    // For a row of a recording whose samples have been pushed.
    virtual Outcome advance_row(double t_s) = 0;
    virtual double newest_time_s() const = 0; // as newest_s, but never runs back
    // Parts of the estimate.
    virtual bool started(At) const = 0;
    virtual Quaternion q_bn(At) const = 0;
    virtual Matrix3 rotation_covariance(At) const = 0; // about the internal navigation axes

    virtual ShownAlong shown_along(const double* seed) const = 0; // of what is shown now

protected:
    ~WholeAttitude() = default;
};

using AttitudeObject = std::conditional_t<small_build, EveryAttitude, WholeAttitude>;

// The calls of every build.
template <class Model>
class SmallAttitudeFilter : public OverFilter<AttitudeObject, Model> {
public:
    using At = EveryAttitude::At;
    using State = typename Model::State;
    using EveryAttitude::frames, EveryAttitude::hold, OverFilter<AttitudeObject, Model>::filter;

    SmallAttitudeFilter(const Frames& in_frames, Hold of_rate) {
        frames = in_frames;
        this->sensors = Model::sensors;
        hold = of_rate;
        this->causal_only = hold != Hold::forward && !Model::reholds;
    }

    void realign() override {
        filter.change([this](State& s) { filter.model().realign(s); });
    }

    Outcome push(const AttitudeSample& sample) override { return filter.push(sample); }
    bool has_room(int count) const override { return filter.has_room(count); }
    void count_refused(bool zero) override { ++(zero ? filter.refused.zero : filter.refused.non_finite); }

    double newest_s() const override { return filter.newest_s(); }
    double stamp_of(double time_s) const override { return filter.stamp_of(time_s); }
    double late_limit_s() const override { return filter.late_limit_s(); }
    Estimate estimate(At at) const override {
        constexpr double max_silence_s = 1; // without samples for longer, no estimate is ready
        Estimate e = model().estimate(state(at));
        if (at == At::shown && filter.event_now_s() - filter.newest_time_s() > max_silence_s)
            e.tilt_ready = e.heading_ready = false;
        return e;
    }
    Vector3 rotation_variances(At at) const override {
        if constexpr (!small_build)
            if (frames.same_navigation) {
                Vector3 v = model().rotation_variances(state(at));
                if (at == At::shown) v.array() += silence_variance();
                return v;
            }
        return frames.template variances_to_user<Scalar>(rotation_covariance_at(at).template cast<Scalar>())
            .template cast<double>();
    }
    Vector3 bias_variances(At at) const override { return model().bias_variances(state(at)); }
    ErrorCovariance error_covariance() const override {
        ErrorCovariance C = model().error_covariance(filter.shown());
        C.diagonal().head<3>().array() += silence_variance();
        return C;
    }
    const InnovationOf<Scalar>& last_innovation(int channel) const override { return filter.newest().innovation[channel]; }

    FieldEstimate field_estimate() const override { return model().field_estimate(filter.newest()); }
    void gyro_calibration(double* S, double* sigma) const override { model().gyro_calibration(filter.newest(), S, sigma); }

    void diagnostics(hnav_diagnostics* out) const override {
        const State& s = filter.newest();
        out->gamma_used = s.gamma;
        out->gamma_margin = s.gamma_margin;
        out->adapted_bias_walk_rad_s_per_sqrt_s = model().bias_walk(s);
        diagnose(filter, out);
        for (int c = 0; c < channel_count; ++c) {
            out->used[c] = s.used[c];
            out->gated[c] = s.gated[c];
        }
        out->corrections = s.corrections;
        out->gamma_raised = s.gamma_raised;
        out->covariance_repaired = s.repaired;
        out->started = s.started != 0;
        out->decay_rate_1_s = model().decay_rate(s);
        out->mean_nis = out->gyro_vibration_rad_s = out->accel_vibration_m_s2 = nan;
    }

    hnav_sensor_health sensor_health(int channel) const override {
        const SensorCheck<Scalar>* check = channel < heading ? &filter.newest().check[channel] : nullptr;
        return hnav::sensor_health(check, filter, channel);
    }

    void health(hnav_health* out) const override {
        const State& s = filter.newest();
        for (int c = 0; c < channel_count; ++c) out->sensor[c] = SmallAttitudeFilter::sensor_health(c);
        for (int c = channel_count; c < HNAV_SENSOR_COUNT; ++c) out->sensor[c] = sensor_without_samples();
        out->times_lost = s.times_lost;
        out->lost = s.lost != 0;
        out->clock_jumps = filter.stamps().jumps();
        out->stamps_left_out = filter.stamps().left_out();
    }

protected:
    Matrix3 rotation_covariance_at(At at) const {
        Matrix3 C = model().rotation_covariance(state(at));
        if (at == At::shown) C.diagonal().array() += silence_variance();
        return C;
    }
    double silence_variance() const { return model().silence_variance(filter.shown(), filter.looked_ahead_s()); }
    const Model& model() const { return filter.model(); }
    const State& state(At at) const { return at == At::shown ? filter.shown() : filter.newest(); }
};

template <class Model>
class WholeAttitudeFilter : public OverWholeFilter<SmallAttitudeFilter<Model>> {
public:
    using Base = OverWholeFilter<SmallAttitudeFilter<Model>>;
    using Base::Base;
    using typename Base::At;
    using typename Base::State;

    bool turns_back() const override { return Model::turns_back; }
    void turn_back(double t_s) override {
        if constexpr (Model::turns_back) {
            const State last = filter.newest();
            filter.reset();
            filter.change([&](State& s) {
                s = last;
                model().turn_back(s, t_s);
            });
        }
    }
    void prefer_closed_form(bool prefer) override { filter.prefer_closed_form(prefer); }

    bool push_event(const AttitudeEvent& event) override { return filter.push_event(event); }
    Outcome advance_row(double t_s) override { return filter.advance_row(t_s); }
    double newest_time_s() const override { return filter.newest_time_s(); }
    bool started(At at) const override { return state(at).started != 0; }
    Quaternion q_bn(At at) const override { return model().attitude(state(at)); }
    Matrix3 rotation_covariance(At at) const override { return this->rotation_covariance_at(at); }

    int quaternion_at() const override { return 0; } // every model has it first
    hnav_status derivative(const double* x, double* dx) const override {
        filter.derivative(x, dx);
        return HNAV_OK;
    }
    hnav_status derivative_along(const double* x, const double* direction, double* out) const override {
        model().flow_along(filter.newest(), x, direction, out);
        return HNAV_OK;
    }
    const char* cannot_jump() const override {
        return this->causal_only ? "gyro_hold is not forward: an integrator outside cannot know the rate before its sample"
                                 : nullptr;
    }
    ShownAlong shown_along(const double* seed) const override {
        return hnav::shown_along(model(), filter.shown(), seed, filter.nx());
    }

protected:
    using Base::filter, Base::model, Base::state;
};

template <class Model>
class AttitudeFilter final : public std::conditional_t<small_build, SmallAttitudeFilter<Model>, WholeAttitudeFilter<Model>> {
public:
    using Base = std::conditional_t<small_build, SmallAttitudeFilter<Model>, WholeAttitudeFilter<Model>>;
    using Settings = typename Filter<Model>::Settings;
    using Base::Base;

    // Null without memory.
    static AttitudeFilter* make(const Model& model, const Frames& frames, Hold hold, const Settings& settings) {
        auto* self = make_object<AttitudeFilter>(frames, hold);
        if (!self) return nullptr;
        if (!self->filter.create(model, settings)) {
            self->destroy();
            return nullptr;
        }
        return self;
    }

    // Bytes that make_in needs at any start address.
    static std::size_t bytes(const Model& model, const Settings& settings) {
        return object_bytes + Filter<Model>::bytes(model, settings) + alignment;
    }
    // By the closed form.
    static AttitudeFilter* make_in(void* memory, const Model& model, const Frames& frames, Hold hold, const Settings& settings) {
        char* const place = aligned(memory);
        std::memset(place, 0, bytes(model, settings) - alignment);
        auto* self = new (place) AttitudeFilter(frames, hold);
        self->in_callers_memory = true;
        self->filter.create_in(place + object_bytes, model, settings);
        return self;
    }

    void destroy() override {
        if constexpr (!small_build)
            if (!this->in_callers_memory) destroy_object(this);
    }

private:
    static constexpr std::size_t alignment = alignof(Base);
    static constexpr std::size_t object_bytes = (sizeof(Base) + alignment - 1) / alignment * alignment;
    static char* aligned(void* memory) {
        const auto first = reinterpret_cast<std::uintptr_t>(memory);
        return static_cast<char*>(memory) + (alignment - first % alignment) % alignment;
    }
};

} // namespace hnav
