// The C boundary of the filter for coloured INS errors.
#include "hnav/hnav.h"

#include "base/memory.hpp"
#include "c_api/arrays.hpp"
#include "c_api/saved_object.hpp"
#include "c_api/sized.hpp"
#include "ins_error/ins_error_filter.hpp"
#include "options/lists.hpp"

#include <cmath>
#include <cstring>

using hnav::InsErrorFilter;
using hnav::Refusal;

// One block of memory: this object, the arenas of the filter, a spare copy of its state, and a row of measurements.
struct hnav_ins_error_filter : hnav::KeptMessage<320> {
    std::optional<InsErrorFilter> filter;
    double* z;
    std::uint64_t fingerprint;

    void reset() { filter->reset(); }
    hnav::SavedState saved() const {
        return {hnav::SavedState::letters("HNAVINSE"), 2, fingerprint, filter->state_count() * sizeof(double)};
    }
    const void* numbers() const { return filter->state(); }
    bool assign(const void* numbers) {
        std::memcpy(filter->state(), numbers, saved().numbers_bytes);
        return true;
    }
};

namespace {

using hnav::copy;
using hnav::row;

hnav::ModelData data_of(const hnav_ins_error_model& m) {
    return {m.nx, m.nu, m.nz, m.nw, m.nl, m.interval_s, m.A, m.B, m.G, m.H, m.An, m.Bn, m.Qw, m.Qv, m.QU, m.Lambda0, m.x0, m.P0};
}

hnav_status step(hnav_ins_error_filter* f, const double* u, const double* z, const std::uint8_t* present) {
    InsErrorFilter& filter = *f->filter;
    if (filter.steps() > 0)
        for (int i = 0; i < filter.model.nu; ++i)
            if (!std::isfinite(u[i]))
                return f->fail(HNAV_ERROR_NON_FINITE, "u[%d] = %g is not finite in step %.0f", i, u[i], filter.steps());
    for (int i = 0; i < filter.model.nz; ++i) {
        f->z[i] = present && !present[i] ? std::nan("") : z[i];
        if (std::isinf(f->z[i]))
            return f->fail(HNAV_ERROR_NON_FINITE, "z[%d] = %g is not finite in step %.0f (NaN is a missing channel)", i, z[i],
                           filter.steps());
    }
    if (filter.step(u, f->z)) return HNAV_OK;
    return f->fail(HNAV_ERROR_SOLVER,
                   "step %.0f has no answer: a covariance is singular or negative, or the estimate without bound; it was dropped",
                   filter.steps());
}

template <class Source>
void copy(const Source& from, double* to) {
    if (!to) return;
    for (int i = 0; i < from.rows(); ++i)
        for (int j = 0; j < from.cols(); ++j) *to++ = from(i, j);
}

void write_row(const InsErrorFilter& f, const hnav_ins_error_run_output& out, std::size_t i) {
    const int nx = f.model.nx, nz = f.model.nz;
    f.estimate(row(out.x, i, nx), row(out.sigma, i, nx));
    f.covariance(row(out.covariance, i, nx * nx));
    f.lambda(row(out.lambda, i, nz), row(out.lambda_sigma, i, nz));
    f.compensated(row(out.compensated, i, nz));
    copy(f.result().innovation, row(out.innovation, i, nz));
    if (out.nis) out.nis[i] = *f.result().nis;
    copy(f.noise_scale(), nz, row(out.noise_scale, i, nz));
    copy(f.fault_probability(), nz, row(out.fault_probability, i, nz));
    copy(f.bias_probability(), nz, row(out.bias_fault_probability, i, nz));
    if (out.process_fault_probability) out.process_fault_probability[i] = f.process_probability();
}

} // namespace

extern "C" {

hnav_status hnav_ins_error_filter_create(hnav_ins_error_filter** filter, const hnav_ins_error_options* options,
                                         const hnav_ins_error_model* model, char* message, size_t message_size) {
    const hnav::CallersMessage caller{message, message_size};
    if (const hnav_status status = caller.begin(filter, "filter", {{options, "options"}, {model, "model"}})) return status;
    hnav_status status = hnav::check_size(caller, *model, "model", "hnav_ins_error_model");
    if (status == HNAV_OK) status = caller.check_options(options, hnav::ins_error_options);
    if (status != HNAV_OK) return status;

    const hnav::ModelData data = data_of(hnav::take_in(*model));
    Refusal why;
    if (!InsErrorFilter::Model::sizes_fit(data, why) || !InsErrorFilter::scaling_has_meaning(*options, data, why))
        return caller.refuse(why);

    // First constructed without memory, to count the bytes.
    hnav::MatrixArena state_size, work_size;
    InsErrorFilter(state_size, work_size, nullptr, data, *options);
    const std::size_t head = (sizeof(hnav_ins_error_filter) + 7) / 8 * 8;
    const std::size_t state_bytes = state_size.used(), row_bytes = data.nz * sizeof(double);
    void* memory = hnav::take_block(head + 2 * state_bytes + row_bytes + work_size.used());
    if (!memory)
        return caller.fail(HNAV_ERROR_OUT_OF_MEMORY, "no memory for a filter with nx = %d, nz = %d, window = %d", data.nx,
                           data.nz, options->window);
    auto* self = new (memory) hnav_ins_error_filter;
    char* block = static_cast<char*>(memory) + head;
    hnav::MatrixArena state(block), work(block + 2 * state_bytes + row_bytes);
    self->filter.emplace(state, work, block + state_bytes, data, *options);
    self->z = reinterpret_cast<double*>(block + 2 * state_bytes);

    if (!self->filter->model.assign(data, why)) {
        hnav_ins_error_filter_destroy(self);
        return caller.refuse(why);
    }
    self->filter->create();
    self->fingerprint = self->filter->model.fingerprint(hnav::fingerprint(hnav::ins_error_options, options));
    *filter = self;
    return HNAV_OK;
}

void hnav_ins_error_filter_destroy(hnav_ins_error_filter* filter) { hnav::destroy_object(filter); }

hnav_status hnav_ins_error_filter_reset(hnav_ins_error_filter* filter) { return hnav::reset_object(filter); }

const char* hnav_ins_error_filter_message(const hnav_ins_error_filter* filter) {
    return filter ? filter->message : "filter is null";
}

const char* hnav_ins_error_filter_warning(const hnav_ins_error_filter* filter) {
    return filter ? filter->filter->model.warning : "filter is null";
}

hnav_status hnav_ins_error_filter_separability(const hnav_ins_error_filter* filter, double* separability) {
    REQUIRE(filter, separability);
    *separability = filter->filter->model.separability;
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_replace_model(hnav_ins_error_filter* filter, const hnav_ins_error_model* model) {
    REQUIRE_STRUCT(filter, model, hnav_ins_error_model);
    Refusal why;
    const hnav::ModelData data = data_of(hnav::take_in(*model));
    if (!InsErrorFilter::scaling_has_meaning(filter->filter->options(), data, why) || !filter->filter->model.assign(data, why))
        return filter->fail(hnav::status_of(why), "%s", why.text);
    filter->filter->prepare();
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_step(hnav_ins_error_filter* filter, const double* u, const double* z, const uint8_t* present) {
    REQUIRE(filter, z);
    if (filter->filter->model.nu > 0) REQUIRE(filter, u);
    return step(filter, u, z, present);
}

hnav_status hnav_ins_error_filter_estimate(const hnav_ins_error_filter* filter, double* x, double* sigma) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    filter->filter->estimate(x, sigma);
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_covariance(const hnav_ins_error_filter* filter, double* P) {
    REQUIRE(filter, P);
    filter->filter->covariance(P);
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_coloured_error(const hnav_ins_error_filter* filter, double* lambda, double* sigma,
                                                 double* out) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    filter->filter->lambda(lambda, sigma);
    filter->filter->compensated(out);
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_innovation(const hnav_ins_error_filter* filter, double* innovation, double* S, double* nis) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    if (filter->filter->steps() == 0) return filter->fail(HNAV_ERROR_NO_DATA, "no sample yet");
    copy(filter->filter->result().innovation, innovation);
    copy(filter->filter->result().S, S);
    if (nis) *nis = *filter->filter->result().nis;
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_noise(const hnav_ins_error_filter* filter, double* scale, double* fault_probability) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    copy(filter->filter->noise_scale(), filter->filter->model.nz, scale);
    copy(filter->filter->fault_probability(), filter->filter->model.nz, fault_probability);
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_faults(const hnav_ins_error_filter* filter, double* noise, double* bias, double* process) {
    if (!filter) return HNAV_ERROR_NULL_ARGUMENT;
    copy(filter->filter->fault_probability(), filter->filter->model.nz, noise);
    copy(filter->filter->bias_probability(), filter->filter->model.nz, bias);
    if (process) *process = filter->filter->process_probability();
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_info(const hnav_ins_error_filter* filter, hnav_ins_error_info* info) {
    REQUIRE_STRUCT(filter, info, hnav_ins_error_info);
    const InsErrorFilter& f = *filter->filter;
    hnav_ins_error_info result{};
    result.steps = static_cast<std::uint64_t>(f.steps());
    result.shown_step = static_cast<std::uint64_t>(f.shown_step());
    result.nx = f.model.nx;
    result.nu = f.model.nu;
    result.nz = f.model.nz;
    result.estimates_lambda = f.estimates_lambda();
    return hnav::hand_out(result, info);
}

hnav_status hnav_ins_error_filter_run(hnav_ins_error_filter* filter, size_t n, const hnav_ins_error_run_input* input,
                                      const hnav_ins_error_run_output* output, size_t* rows_done) {
    if (rows_done) *rows_done = 0;
    REQUIRE_STRUCT(filter, input, hnav_ins_error_run_input);
    REQUIRE_STRUCT(filter, output, hnav_ins_error_run_output);
    const int nu = filter->filter->model.nu, nz = filter->filter->model.nz;
    if (n > 0) REQUIRE(filter, input->z);
    if (n > 0 && nu > 0) REQUIRE(filter, input->u);
    const hnav_ins_error_run_input in = hnav::take_in(*input);
    const hnav_ins_error_run_output out = hnav::take_in(*output);
    for (size_t i = 0; i < n; ++i) {
        const hnav_status status =
            step(filter, nu > 0 ? in.u + i * nu : nullptr, in.z + i * nz, in.present ? in.present + i * nz : nullptr);
        if (status != HNAV_OK) return status;
        write_row(*filter->filter, out, i);
        if (rows_done) *rows_done = i + 1;
    }
    return HNAV_OK;
}

hnav_status hnav_ins_error_filter_state_size(const hnav_ins_error_filter* filter, size_t* bytes) {
    return hnav::give_state_size(filter, bytes);
}

hnav_status hnav_ins_error_filter_save(const hnav_ins_error_filter* filter, void* buffer, size_t bytes) {
    return hnav::save_object(filter, buffer, bytes);
}

hnav_status hnav_ins_error_filter_load(hnav_ins_error_filter* filter, const void* buffer, size_t bytes) {
    return hnav::load_object(filter, buffer, bytes, "filter");
}

} // extern "C"
