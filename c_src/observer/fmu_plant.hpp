// An FMU in Model Exchange as a plant without events: its answers depend on time, states, inputs and parameters alone, so
// it may be asked anywhere in any order. Between calls it is in continuous-time mode.
#pragma once

#include "observer/fmi_instance.hpp"
#include "observer/plan.hpp"

namespace hnav::observer {

class FmuPlant final : public Plant {
public:
    // Loads and initialises an instance; takes from it what the plan leaves to the FMU: starts and nominal values. Null: why
    // says it.
    static FmuPlant* open(const char* folder, Plan& plan, double start_s, Refusal& why);
    ~FmuPlant() { close(); }

    Answer evaluate(Function function, const Point& at, double* values) override;
    bool offers(Function function, Variable variable) const override;
    Answer jacobian(Function function, const bool (&wanted)[variables], const Point& at, double* J) override;
    int state_of_output(int output) const override;
    const char* said() const override { return said_; }
    void destroy() override;

private:
    bool load(const char* folder, Refusal& why);
    bool start(Refusal& why);
    bool restart();
    bool initialise(Refusal& why);
    bool take_starts(Plan& plan, Refusal& why);
    void close();

    Answer move_to(const Point& at);
    Answer change_discrete(const Point& at);
    Answer iterate();
    Answer columns(Function function, Variable variable, double* J);
    Answer keep(Answer answer, const char* call);

    SharedLibrary library_;
    FmiInstance* fmi_ = nullptr;
    Plan plan_;
    char resources_[max_path] = "", said_[320] = "";
    double start_s_ = 0;
    bool running_ = false;
    // What the instance was given last.
    double inputs_[max_inputs] = {}, parameters_[max_estimated] = {}, column_[max_estimated] = {};
};

} // namespace hnav::observer
