// The calls of the filter for coloured INS errors in any order, with any matrices.
#include "ins_error.hpp"

namespace {

using fuzz::Input;

hnav_ins_error_options options_from(Input& in, int head) {
    hnav_ins_error_options options = hnav_ins_error_defaults();
    options.form = in.choice(5);
    if (options.form == HNAV_INS_ERROR_MDKF || options.form == HNAV_INS_ERROR_AMDKF) options.joseph = 0;
    options.noise_scaling = head & 1 ? in.choice(5) : HNAV_NOISE_SCALING_NONE;
    options.window = 1 + in.choice(8);
    if (!(head & 2)) return options;
    int rows = 0;
    while (hnav_option("ins_error", rows)) ++rows;
    const hnav_option_info* info = hnav_option("ins_error", in.choice(rows));
    auto* field = reinterpret_cast<unsigned char*>(&options) + info->offset;
    if (info->kind == HNAV_OPTION_REAL) {
        const double value = in.number();
        std::memcpy(field, &value, 8);
    } else {
        const std::int32_t value = static_cast<std::int8_t>(in.byte());
        std::memcpy(field, &value, 4);
    }
    return options;
}

// Changes of the good model: elements of any value, symmetric where they must be, or matrices left out.
void change(Input& in, fuzz::InsErrorModel& m) {
    struct {
        double* values;
        const double** place;
        int n;
        bool symmetric;
    } matrices[] = {{m.A, &m.view.A, 4, false},   {m.B, &m.view.B, 2, false},
                    {m.G, &m.view.G, 4, false},   {m.H, &m.view.H, 4, false},
                    {m.An, &m.view.An, 4, false}, {m.Bn, &m.view.Bn, 4, false},
                    {m.Qw, &m.view.Qw, 4, true},  {m.Qv, &m.view.Qv, 4, true},
                    {m.QU, &m.view.QU, 4, true},  {m.Lambda0, &m.view.Lambda0, 4, true},
                    {m.x0, &m.view.x0, 2, false}, {m.P0, &m.view.P0, 4, true}};
    for (int n = in.choice(6); n > 0; --n) {
        auto& matrix = matrices[in.choice(12)];
        const int kind = in.choice(8);
        if (kind == 0) {
            *matrix.place = nullptr;
        } else if (kind == 1) {
            m.view.interval_s = in.number();
        } else if (kind == 2) {
            std::int32_t* sizes[] = {&m.view.nx, &m.view.nu, &m.view.nz, &m.view.nw, &m.view.nl};
            // No larger than the arrays, but for numbers that create has to refuse before it reads them.
            const std::int32_t values[] = {-1, 0, 1, 33, INT32_MAX, INT32_MIN};
            const int which = in.choice(5);
            const std::int32_t value = values[in.choice(6)];
            if (which != 1 || value != 33) *sizes[which] = value;
        } else {
            const int i = in.choice(matrix.n);
            // No larger than rounding leaves sense in: a covariance of numbers of 1e100 has no sign any more.
            const double value = in.number();
            matrix.values[i] = std::isfinite(value) && std::fabs(value) > 1e6 ? 1e6 : value;
            if (matrix.symmetric && i % 3 != 0) matrix.values[3 - i] = matrix.values[i];
        }
    }
}

void call(hnav_ins_error_filter* filter, bool printed, fuzz::InsErrorModel& model, std::vector<unsigned char>& state, Input& in) {
    double u[32] = {}, z[32] = {};
    std::uint8_t present[32] = {1, 1};
    hnav_status status = HNAV_OK;
    switch (in.choice(8)) {
    case 0:
    case 1:
    case 2:
        u[0] = in.number();
        in.vector(z, 2);
        present[in.choice(2)] = in.flag();
        status = hnav_ins_error_filter_step(filter, u, z, in.flag() ? present : nullptr);
        break;
    case 3:
        z[0] = in.fraction();
        z[1] = in.fraction();
        status = hnav_ins_error_filter_step(filter, u, z, nullptr);
        break;
    case 4: state = fuzz::saved(filter); break;
    case 5:
        if (!state.empty()) HOLDS(hnav_ins_error_filter_load(filter, state.data(), state.size()) == HNAV_OK);
        break;
    case 6: {
        fuzz::InsErrorModel other;
        change(in, other);
        const hnav_ins_error_model& old = model.view;
        const bool same_sizes = other.view.nx == old.nx && other.view.nu == old.nu && other.view.nz == old.nz;
        status = hnav_ins_error_filter_replace_model(filter, &other.view);
        if (!same_sizes) HOLDS(status != HNAV_OK);
        break;
    }
    default: {
        double rows_u[4] = {}, rows_z[8], x[8], nis[4];
        in.vector(rows_z, 8);
        const hnav_ins_error_run_input input{sizeof(hnav_ins_error_run_input), rows_u, rows_z, nullptr};
        auto output = hnav_sized<hnav_ins_error_run_output>();
        output.x = x;
        output.nis = nis;
        auto s = hnav_sized<hnav_ins_error_info>();
        HOLDS(hnav_ins_error_filter_info(filter, &s) == HNAV_OK);
        std::size_t done = 99;
        status = in.flag() ? hnav_ins_error_filter_reset(filter) : hnav_ins_error_filter_run(filter, 4, &input, &output, &done);
        if (done <= 4) HOLDS(fuzz::finite(x, static_cast<int>(done) * s.nx));
        break;
    }
    }
    fuzz::answered(status, hnav_ins_error_filter_message(filter));
    fuzz::look(filter, printed);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    Input in(bytes, size);
    const int head = in.byte();
    const hnav_ins_error_options options = options_from(in, head);
    fuzz::InsErrorModel model;
    if (head & 4) change(in, model);
    hnav_ins_error_filter* filter = nullptr;
    char message[256] = "";
    const hnav_status status = hnav_ins_error_filter_create(&filter, &options, &model.view, message, sizeof message);
    fuzz::answered(status, message);
    HOLDS((filter != nullptr) == (status == HNAV_OK));
    if (!filter) return 0;
    const bool printed = options.form == HNAV_INS_ERROR_MDKF || options.form == HNAV_INS_ERROR_AMDKF;
    std::vector<unsigned char> state;
    for (int calls = 0; calls < 100 && !in.end(); ++calls) call(filter, printed, model, state, in);
    // Whatever came before: after a reset to x0 and P0 it takes a step as long as the present model can.
    HOLDS(hnav_ins_error_filter_reset(filter) == HNAV_OK);
    fuzz::look(filter, printed);
    hnav_ins_error_filter_destroy(filter);
    return 0;
}
