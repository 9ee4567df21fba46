// An FMU in Model Exchange as a plant. Without events its values depend on time, states, inputs and parameters only, and it can be
// evaluated at any point. With events they depend on its discrete state too, which is saved after each event and restored before a
// continuation from another one. Between calls it is in continuous-time mode.
#pragma once

#include "observer/fmi_instance.hpp"
#include "observer/fmu_memory.hpp"
#include "observer/live_plant.hpp"
#include "observer/plan.hpp"

namespace hnav::observer {

class FmuPlant final : public Plant {
public:
    // Loads and initialises an instance; takes start and nominal values from it where the plan has none. Null: why has the
    // reason.
    static FmuPlant* open(const char* folder, Plan& plan, double start_s, Refusal& why);
    ~FmuPlant() { close(); }

    LivePlant live;

    Answer evaluate(Function function, const Point& at, double* values) override;
    Answer step(const Point& from, double length_s, double* x) override;
    bool offers(Function function, Variable variable) const override;
    Answer jacobian(Function function, const bool (&wanted)[variables], const Point& at, const Dependencies& dependencies,
                    double* J) override;
    bool declares_dependencies() const override;
    bool depends(int derivative, int on) const override { return plan_.depends(derivative, on); }
    Answer indicators(const Point& at, double* z) override;
    Answer event(const Point& at, double* x, double* next_s) override;
    Answer remember(double* memory) override;
    Answer recall(const double* memory) override;
    void hold(const double* memory, int by) override;
    Answer step_done(const Point& at, bool* wants_event) override;
    bool memory_lasts() const override { return sizes.memory == 0 || memory_.serialises(); }
    double first_event_s() override { return first_event_s_; }
    bool go_to_start(Refusal& why) override;
    // Returns to the held state after evaluations at other points. False: the instance is lost.
    bool back_at_start() { return running_ && recall(held_) == Answer::ok; }
    const Plan* plan() const { return &plan_; }
    int state_of_output(int output) const override;
    const char* said() const override { return said_; }
    void destroy() override;

private:
    bool prepare(const Plan& plan);
    std::size_t place_rows(void* block);
    void list_asked();
    bool load(const char* folder, Refusal& why);
    bool start(Refusal& why);
    bool restart();
    bool refuse(Refusal& why) const;
    bool initialise(Refusal& why);
    Answer begin_continuous_time();
    bool take_starts(Plan& plan, Refusal& why);
    bool begin_events(Refusal& why);
    bool begin_steps(Refusal& why);
    bool states_follow(const double* x, const double* after, double* moved, Refusal& why);
    bool sensors_follow(const double* x, const double* after, Refusal& why);
    bool take_memory(Refusal& why);
    void free_instance();
    void close();
    bool by_steps() const { return plan_.step_s > 0; }
    int inputs_and_parameters() const { return sizes.inputs + sizes.parameters; }
    int before_memory() const { return inputs_and_parameters() + 1; } // the time of its saved state

    Answer move_to(const Point& at);
    Answer place(const Point& at);
    Answer rates(const Point& at, double* values);
    bool differs(const Point& at) const;
    Answer change_discrete(const Point& at);
    Answer iterate();
    Answer columns_of_outputs(Variable variable, double* J);
    Answer columns_of_derivatives(Variable variable, const Dependencies& dependencies, double* J);
    Reference known(int column) const;
    Answer keep(Answer answer, const char* call);
    Answer unless_terminated(Answer answer, bool terminate);
    Answer ended(Answer answer);

    SharedLibrary library_;
    FmiInstance* fmi_ = nullptr;
    Plan plan_;
    char resources_[max_path] = "", said_[320] = "";
    double start_s_ = 0;
    double t_s_ = 0; // of an instance that makes steps
    bool running_ = false, lost_ = false;
    // The discrete state, and whether the instance has continued from it.
    FmuMemory memory_;
    double* held_ = nullptr;
    bool has_gone_on_ = false;
    bool is_moved_ = false; // to a time and states other than those it was saved at
    double next_event_s_ = HUGE_VAL, first_event_s_ = HUGE_VAL;
    // Variables of sensors, each once, and the one of each sensor: some FMUs return a repeated variable once.
    Reference asked_[max_channels_used] = {};
    int asked_as_[max_channels_used] = {}, asked_count_ = 0;
    // The values set last; room for a column of derivatives, and for the variables of a group with their seed.
    void* rows_ = nullptr;
    double *inputs_ = nullptr, *parameters_ = nullptr, *column_ = nullptr, *ones_ = nullptr;
    Reference* together_ = nullptr;
};

} // namespace hnav::observer
