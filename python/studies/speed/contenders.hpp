// What is timed: a filter over the samples of a recording, with the outputs that its name says.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

// Rows of one instant each, n x 3 by row.
struct Samples {
    std::size_t n;
    const double *t_s, *rate_rad_s, *force_m_s2, *field_tesla;
    double interval_s() const { return (t_s[n - 1] - t_s[0]) / double(n - 1); }
};

struct Results {
    double* q;         // n x 4
    double* sigma_rad; // n x 3
};

class Contender {
public:
    virtual ~Contender() = default;
    virtual void begin(const Samples& samples) = 0; // as just made; not timed
    virtual void run(const Samples& samples, const Results& results) = 0;
};

// Null: there is none of that name. Peers may be left out of a program.
std::unique_ptr<Contender> own_contender(const std::string& name);
__attribute__((weak)) std::unique_ptr<Contender> peer_contender(const std::string& name);
