// One instance of the FMU for all FMI versions: values, mode, time, and the rules about calls. fmi2.cpp and fmi3.cpp
// translate names and types only.
#pragma once

#include "adapter/lifecycle.hpp"
#include "adapter/model.hpp"

#include <cstdarg>

namespace hnav::fmu {

// A warning is logged and not returned: the call has succeeded.
enum class Status { ok, warning, error };

class Instance : public Allocated {
public:
    // Where messages go: the importer's logger behind one signature.
    using Logger = void (*)(const Instance& instance, Status status, const char* text);

    struct Importer {
        void* environment = nullptr;
        void* callback = nullptr; // the logger of the version, cast back by Logger
        Logger log = nullptr;
    };

    struct Options {
        Interface interface = co_simulation;
        bool event_mode_used = false;
        bool early_return_allowed = false;
        bool logging_on = false; // events too; errors and warnings are always logged
        const char* resources = nullptr; // the folder as a path; used while an instance is made
    };

    // The reply to a step.
    struct Step {
        bool event_handling_needed = false;
        bool early_return = false;
        double last_successful_s = 0;
    };

    // Called at the end of a step, while it is still under way for the importer.
    using IntermediateUpdate = void (*)(Instance& instance, double t_s);

    struct Events {
        bool update_needed = false; // another iteration at this instant
        bool states_changed = false;
        bool next_event_defined = false;
        double next_event_s = 0;
    };

    // Null without memory or for a token of another version; the logger receives the reason.
    static Instance* create(const char* name, const char* token, const Options& options, const Importer& importer);
    ~Instance();

    // False, with a logged reason, when the call is not allowed now.
    bool allowed(Call call) const {
        const Rule& rule = rule_of(call);
        return ((rule.interfaces & options_.interface) && (rule.modes & mode_)) || refuse(rule);
    }
    Status permit(Call call) const { return allowed(call) ? Status::ok : Status::error; }
    Status fail(const char* format, ...) const __attribute__((format(printf, 2, 3)));
    // The log category of a status.
    static const char* category(Status status);
    // Switches the named categories on or off; without names, as at creation.
    Status set_debug_logging(bool on, std::size_t n, const char* const* categories);

    // -------------------------------------------------------------------------------------------- life
    Status set_up_experiment(double start_s, bool stop_defined, double stop_s);
    Status enter_initialization();
    Status exit_initialization(bool fmi2);
    Status change_mode(Call call, Mode mode);
    Status terminate();
    Status reset();

    // -------------------------------------------------------------------------------------------- variables
    // T: the C type of the value; type: that of the rows it may name.
    template <class T>
    Status get(Type type, const unsigned* references, std::size_t n, T* out);
    template <class T>
    Status set(Type type, const unsigned* references, std::size_t n, const T* in);
    Status check_array(const unsigned* references, std::size_t n, const void* values, std::size_t n_values) const;
    // Type of the variable with this value reference, if there is one.
    bool is_enumeration(unsigned reference) const { return slot(reference).type == Type::enumeration; }

    Status get_clocks(const unsigned* references, std::size_t n, bool* active);
    Status set_clocks(const unsigned* references, std::size_t n, const bool* active);

    // -------------------------------------------------------------------------------------------- Co-Simulation
    Status do_step(double t_s, double step_s, IntermediateUpdate update, Step* reply);

    // -------------------------------------------------------------------------------------------- events, Model Exchange
    Status update_discrete_states(Events* events);
    Status set_time(double t_s);
    Status set_states(const double* x, std::size_t n);
    Status get_states(double* x, std::size_t n);
    Status get_derivatives(double* dx, std::size_t n);
    Status get_indicators(double* z, std::size_t n);
    Status step_done(bool* wants_event);
    Status get_nominals(double* nominals, std::size_t n);
    // As many seeds and sensitivities as the variables have elements.
    Status directional_derivative(const unsigned* unknowns, std::size_t n_unknowns, const unsigned* knowns, std::size_t n_knowns,
                                  const double* seed, std::size_t n_seed, double* sensitivity, std::size_t n_sensitivity);
    Status adjoint_derivative(const unsigned* unknowns, std::size_t n_unknowns, const unsigned* knowns, std::size_t n_knowns,
                              const double* seed, std::size_t n_seed, double* sensitivity, std::size_t n_sensitivity);

    // -------------------------------------------------------------------------------------------- complete state
    struct Snapshot {
        std::size_t bytes;
    }; // followed by the numbers
    Status take_snapshot(Snapshot** snapshot);
    Status restore_snapshot(const Snapshot* snapshot);
    Status release_snapshot(Snapshot** snapshot);
    Status get_snapshot_bytes(const Snapshot* snapshot, std::size_t* bytes) const;
    Status serialise(const Snapshot* snapshot, unsigned char* bytes, std::size_t size) const;
    Status deserialise(const unsigned char* bytes, std::size_t size, Snapshot** snapshot) const;

    const Table& table() const { return table_; }
    const Model& model() const { return *model_; }
    const Options& options() const { return options_; }
    const Importer& importer() const { return importer_; }
    const char* name() const { return name_; }
    int state_count() const { return state_count_; }
    int indicator_count() const { return model_->indicator_count(); }
    double time_s() const { return time_s_; }
    void* intermediate_callback = nullptr;

    static void format_token(std::uint64_t token, char* text, std::size_t size);

private:
    struct Header;
    // Properties of a variable that getting and setting need, in one cache line.
    struct Slot {
        int row, rows; // the first row, and their number; 0 if there is no variable
        unsigned group;
        Type type;
        bool is_input;
        bool is_of(Type asked) const { return rows > 0 && type == asked; }
    };

    Instance() = default;
    void restart();
    Status check_time(const char* name, double t_s) const;
    void say(Status status, const char* format, va_list arguments) const;
    void warn(const char* format, ...) const __attribute__((format(printf, 2, 3)));
    void note(const char* format, ...) const __attribute__((format(printf, 2, 3)));
    void set_logging(bool on);
    bool take_samples(double t_s);
    void say_what_was_lost(double apart_s);
    void say(const Lost& lost, double apart_s) const;
    bool sample_inside(double end_s, Message* why);
    Status process_samples(bool* states_changed);
    Status make_table();
    void index_table();
    Status set_up_check(const char* name, const char* token);
    Status check_step(double t_s, double step_s) const;
    // The row of a value reference; null, with a message, if there is none or it has another type.
    const Variable* row_of(unsigned reference) const;
    const Variable* row_of(unsigned reference, Type type) const;
    bool refuse(const Rule& rule) const; // false, with the reason
    Status check_value(const Variable& row, double value) const;
    void take_states(const unsigned* references, std::size_t n);
    template <class T>
    Status check_values(unsigned reference, const T* values) const;
    // A reference without a variable gets the slot of reference 0, which has none.
    const Slot& slot(unsigned reference) const { return slots_[reference < slot_count_ ? reference : 0]; }
    std::size_t elements(const unsigned* references, std::size_t n) const;
    Status check_states(const double* x, std::size_t n) const;
    Status check_pairs(const unsigned* unknowns, std::size_t n_unknowns, const unsigned* knowns, std::size_t n_knowns) const;
    double adjoint_along(int row, const unsigned* unknowns, std::size_t n_unknowns, const double* seed);
    const double* rows_along(double* direction);
    // A clock is active from its tick until the end of the iteration that has processed it.
    double* seen_ticks() const { return values_ + table_.size(); }
    std::size_t value_count() const { return static_cast<std::size_t>(table_.size()) + static_cast<std::size_t>(clock_count_); }
    int clock_of(unsigned reference) const;
    Status any_clock_active(bool* active);
    Status end_ticks(bool* input_ticked);
    Status make_ready();
    Status refresh(unsigned groups);
    std::size_t snapshot_bytes() const;
    // Offset and size in bytes of the model's numbers in a snapshot; null if it has none.
    const unsigned char* model_in(const Snapshot* snapshot, std::size_t* bytes) const;
    bool can_serialise(const Snapshot* snapshot) const; // false, with the reason
    void release_model(const Snapshot* snapshot);
    std::uint64_t parameter_hash() const;

    Table table_;
    Model* model_ = nullptr;
    Options options_;
    Importer importer_;
    char name_[128] = "";
    double* values_ = nullptr; // one for each row; behind them the processed ticks of each clock
    static constexpr int max_clocks = 16;
    int clock_row_[max_clocks] = {};
    int clock_count_ = 0;
    Slot* slots_ = nullptr;    // by value reference
    unsigned slot_count_ = 0;
    int time_row_ = -1; // of the independent variable
    int state_count_ = 0;
    double* states_ = nullptr; // the importer's, in Model Exchange
    double* scratch_ = nullptr; // of a directional derivative: the direction, and a number for each row
    Mode mode_ = instantiated;
    bool has_model_ = false; // initialised
    bool touched_ = true;    // until the model is ready for initialization mode: something was set since
    std::uint64_t token_ = 0;      // of the table
    std::uint64_t parameters_ = 0; // hash of the values that the model was created with
    bool logged_[3] = {};    // by status
    bool said_lost_ = false, said_sparse_ = false, said_mistaken_ = false, said_repeated_ = false, said_refused_[refusals] = {},
         judged_ = false;
    const char* said_implausible_ = nullptr; // the newest finding
    double seen_s_ = 0;      // time of the last look at the inputs
    unsigned stale_ = 0;     // groups whose rows are older than the model
    int first_state_ = -1, first_derivative_ = -1; // rows; states and derivatives stand together, in order
    double time_s_ = 0, start_s_ = 0, stop_s_ = 0;
};

} // namespace hnav::fmu
