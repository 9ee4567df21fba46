// VQF, BasicVQF and offlineVQF (Laidig and Seel 2023) and Fusion (x-io), each as its documentation calls it.
#include "contenders.hpp"

#include <basicvqf.hpp>
#include <offline_vqf.hpp>
#include <vqf.hpp>
extern "C" {
#include <Fusion.h>
}

namespace {

template <class Filter>
class Vqf : public Contender {
public:
    void begin(const Samples& samples) override { filter_ = std::make_unique<Filter>(samples.interval_s()); }
    void run(const Samples& s, const Results& results) override {
        for (std::size_t k = 0; k < s.n; ++k) {
            filter_->update(s.rate_rad_s + 3 * k, s.force_m_s2 + 3 * k, s.field_tesla + 3 * k);
            filter_->getQuat9D(results.q + 4 * k);
        }
    }

private:
    std::unique_ptr<Filter> filter_;
};

class OfflineVqf : public Contender {
public:
    void begin(const Samples&) override {}
    void run(const Samples& s, const Results& results) override {
        offlineVQF(s.rate_rad_s, s.force_m_s2, s.field_tesla, s.n, s.interval_s(), VQFParams(), nullptr, results.q, nullptr,
                   nullptr, nullptr, nullptr, nullptr);
    }
};

// Takes degrees and g, in single precision.
class Fusion : public Contender {
public:
    void begin(const Samples& samples) override {
        FusionAhrsInitialise(&ahrs_);
        FusionAhrsSettings settings = fusionAhrsDefaultSettings;
        settings.sampleRate = static_cast<float>(1 / samples.interval_s());
        FusionAhrsSetSettings(&ahrs_, &settings);
    }
    void run(const Samples& s, const Results& results) override {
        for (std::size_t k = 0; k < s.n; ++k) {
            FusionAhrsUpdate(&ahrs_, scaled(s.rate_rad_s + 3 * k, 180 / M_PI), scaled(s.force_m_s2 + 3 * k, 1 / 9.80665),
                             scaled(s.field_tesla + 3 * k, 1e6));
            const FusionQuaternion q = FusionAhrsGetQuaternion(&ahrs_);
            for (int i = 0; i < 4; ++i) results.q[4 * k + i] = q.array[i];
        }
    }

private:
    static FusionVector scaled(const double* v, double factor) {
        return {{static_cast<float>(v[0] * factor), static_cast<float>(v[1] * factor), static_cast<float>(v[2] * factor)}};
    }
    FusionAhrs ahrs_;
};

} // namespace

std::unique_ptr<Contender> peer_contender(const std::string& name) {
    if (name == "vqf") return std::make_unique<Vqf<VQF>>();
    if (name == "basicvqf") return std::make_unique<Vqf<BasicVQF>>();
    if (name == "offlinevqf") return std::make_unique<OfflineVqf>();
    if (name == "fusion") return std::make_unique<Fusion>();
    return nullptr;
}
