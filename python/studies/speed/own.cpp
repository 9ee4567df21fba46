// Our filters over whole arrays, as the C interface offers them. Names: FILTER[-smooth]:OUTPUTS[:closed_form][:gamma=MODE], OUTPUTS q or
// sigma, MODE of the HREKF.
#include "contenders.hpp"

#include <hnav/hnav.h>

#include <stdexcept>

namespace {

void demand(hnav_status status, const char* what) {
    if (status != HNAV_OK) throw std::runtime_error(what);
}

// create: that of the filter.
template <class Options>
hnav_filter* made(Options options, hnav_status (*create)(hnav_filter**, const Options*, char*, size_t), const std::string& name) {
    if (name.find(":closed_form") != std::string::npos) options.solver = HNAV_SOLVER_CLOSED_FORM;
    hnav_filter* filter = nullptr;
    demand(create(&filter, &options, nullptr, 0), "a filter with these options");
    return filter;
}

hnav_hrekf_options with_gamma(hnav_hrekf_options options, const std::string& name) {
    const std::pair<const char*, int> modes[] = {
        {"off", HNAV_GAMMA_OFF}, {"fixed", HNAV_GAMMA_FIXED}, {"relative", HNAV_GAMMA_RELATIVE}, {"kl", HNAV_GAMMA_KL}};
    for (const auto& [mode, number] : modes)
        if (name.find(std::string(":gamma=") + mode) != std::string::npos) options.gamma_mode = number;
    return options;
}

class Own : public Contender {
public:
    Own(hnav_filter* filter, bool smooth, bool sigma) : filter_(filter), smooth_(smooth), sigma_(sigma) {}
    ~Own() override { hnav_filter_destroy(filter_); }
    void begin(const Samples&) override { demand(hnav_filter_reset(filter_), "hnav_filter_reset"); }
    void run(const Samples& s, const Results& results) override {
        hnav_run_input input{};
        input.size = sizeof input;
        input.t_s = s.t_s;
        input.rate_b_rad_s = s.rate_rad_s;
        input.force_b_m_s2 = s.force_m_s2;
        input.field_b_tesla = s.field_tesla;
        hnav_run_output output{};
        output.size = sizeof output;
        output.q_nb = results.q;
        if (sigma_) output.sigma_rad = results.sigma_rad;
        demand(
            smooth_ ? hnav_filter_smooth(filter_, s.n, &input, &output) : hnav_filter_run(filter_, s.n, &input, &output, nullptr),
            hnav_filter_message(filter_));
    }

private:
    hnav_filter* filter_;
    bool smooth_, sigma_;
};

} // namespace

std::unique_ptr<Contender> own_contender(const std::string& name) {
    const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
    const bool smooth = has("-smooth"), sigma = has(":sigma");
    if (name.rfind("ahrs", 0) == 0)
        return std::make_unique<Own>(made(hnav_ahrs_defaults(HNAV_PRESET_DEFAULT), hnav_ahrs_create, name), smooth, sigma);
    if (name.rfind("hrekf", 0) == 0) {
        const auto options = with_gamma(hnav_hrekf_defaults(HNAV_PRESET_DEFAULT), name);
        return std::make_unique<Own>(made(options, hnav_hrekf_create, name), smooth, sigma);
    }
    return nullptr;
}
