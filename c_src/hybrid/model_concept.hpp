// What a model is: the mathematics that Filter<Model> asks for, and nothing else. A model is a value (it is copied into
// its filter) whose members are const: all that changes stands in its State.
//
// Sizes, known when the model is compiled:
//     static constexpr int nx                             continuous states
//     using Event = FixedEvent<channels, values>
//     struct State { double x[nx]; ... }                  8-byte numbers only, x first; float x in a small build
// or when it is made:
//     using Event = RuntimeEvent; using State = RuntimeState
//     int nx() const                                      continuous states
//     int channels() const                                at most 63
//     int values() const                                  of one reading, the same for all channels
//     std::size_t state_bytes() const                     of a state, x and what the model puts behind it
//
// Start and flow:
//     void begin(State&) const                            from zeros to the state before any sample
//     bool flows(const State&) const                      false while there is nothing to integrate
//     void flow(const State&, const double* x, double* dx) const       x' = f(x), inputs held in the state; a flow that may be
//                                                         without an answer returns an int as Propagator::Flow does
//     struct Piece                                        where the flow depends on more than State and x, a last argument of flow
//                                                         with a default: a part of the state, a point without its matrices
//     void nominal(double* x) const                       sizes that absolute tolerances are relative to
//     bool plausible(const State&) const                  false when finite numbers lie beyond all sense
//     void normalise(State&) const                        x has come from an integrator outside: what it strained is restored
//
// Events:
//     void before_flow(State&, const Event&) const        inputs of an event that act on the interval before it
//     void jump(State&, const Event&) const               the correction; the state is at the event
//
// Optional abilities, which a model declares:
//     static constexpr bool has_closed_form               the flow over an interval without an integrator:
//         void flow_exactly(State&, double interval_s) const
//     static constexpr bool bounds_rate                    how fast the flow goes under the inputs that are held, so that an
//                                                         interval needs no error control: rad/s of its fastest mode
//         double fastest_rate(const State&) const
//     static constexpr int read                           the flow reads so many numbers of x, the first; the others only grow
//     static constexpr bool reholds                       an integrator outside has crossed the interval without the inputs
//                                                         of before_flow: they are put in afterwards
//         void rehold(State&, const Event&, double interval_s) const
//     static constexpr bool turns_back                    a filter that has seen a recording goes through it again with time
//                                                         reversed, its next sample at t_s
//         void turn_back(State&, double t_s) const
//     bool cross(State&, double interval_s, Propagator&, const void* context) const      the flow over an interval with events of
//                                                         its own, which Settings.looks_inside of the propagator is for; false: the
//                                                         state is of no use
//         bool crosses() const                            whether it is to be asked
//     bool flow_stiffly(State&, double interval_s, Propagator& counts) const     the flow over an interval by a solver of its own,
//                                                         where the integrator ran out of steps, or is_stiff; false: the state
//                                                         is of no use
//         bool is_stiff(const State&) const
//         bool by_points() const                          the flow goes by sigma points altogether:
//         bool flow_by_points(State&, double interval_s, Propagator&, const void* context) const
//         static constexpr long max_explicit_steps        of the integrator, before it is asked
//     static constexpr std::uint64_t bursts               mask of the channels whose samples of one stamp come from a FIFO
//                                                         (stamps.hpp); without it all
//     static std::uint64_t seldom_changes(const State&)   counts the changes of a part of the state that few events change:
//         static constexpr std::size_t seldom_begin, seldom_bytes
//
// Without a closed form an interval that the integrator cannot cross is an error, and its event is dropped.
#pragma once

#include "hybrid/sizes.hpp"

#include <cstdint>
#include <type_traits>
#include <utility>

namespace hnav {
namespace model_concept {

template <class M>
using State = typename M::State;
template <class M>
using Event = typename M::Event;
template <class T>
T& object(); // for expressions in unevaluated contexts

// Type of the numbers of x.
template <class S, class = void>
struct RealOf {
    using type = double;
};
template <class S>
struct RealOf<S, std::void_t<std::remove_extent_t<decltype(S::x)>[1]>> {
    using type = std::remove_extent_t<decltype(S::x)>;
};
template <class M>
using Real = typename RealOf<State<M>>::type;

// Whether Expression<Model> compiles.
template <template <class> class Expression, class Model, class = void>
struct Answers : std::false_type {};
template <template <class> class Expression, class Model>
struct Answers<Expression, Model, std::void_t<Expression<Model>>> : std::true_type {};

template <class M>
using Begin = decltype(object<const M>().begin(object<State<M>>()));
template <class M>
using Flows = std::enable_if_t<std::is_same_v<bool, decltype(object<const M>().flows(object<const State<M>>()))>>;
template <class M>
using Flow = decltype(object<const M>().flow(object<const State<M>>(), object<const Real<M>* const>(), object<Real<M>* const>()));
template <class M>
constexpr bool flow_may_fail = std::is_same_v<int, Flow<M>>;
template <class M>
using Nominal = decltype(object<const M>().nominal(object<Real<M>* const>()));
template <class M>
using Plausible = std::enable_if_t<std::is_same_v<bool, decltype(object<const M>().plausible(object<const State<M>>()))>>;
template <class M>
using Normalise = decltype(object<const M>().normalise(object<State<M>>()));
template <class M>
using BeforeFlow = decltype(object<const M>().before_flow(object<State<M>>(), object<const Event<M>>()));
template <class M>
using Jump = decltype(object<const M>().jump(object<State<M>>(), object<const Event<M>>()));
template <class M>
using FlowExactly = decltype(object<const M>().flow_exactly(object<State<M>>(), 0.0));
template <class M>
using FastestRate = std::enable_if_t<std::is_same_v<double, decltype(object<const M>().fastest_rate(object<const State<M>>()))>>;
template <class M>
using Rehold = decltype(object<const M>().rehold(object<State<M>>(), object<const Event<M>>(), 0.0));
template <class M>
using TurnBack = decltype(object<const M>().turn_back(object<State<M>>(), 0.0));

template <class M>
using Crosses = decltype(object<const M>().crosses());
template <class M>
using Stiff = decltype(object<const M>().is_stiff(object<const State<M>>()));
template <class M>
using Hold = decltype(object<const M>().hold(object<State<M>>(), 0.0),
                      object<const M>().miss(object<State<M>>(), object<const Event<M>>()), object<const M>().open_interval());
template <class M>
using SeldomChanges = decltype(M::seldom_changes(object<const State<M>>()));
template <class M>
using Read = std::integral_constant<int, M::read>;
template <class M>
using Bursts = std::integral_constant<std::uint64_t, M::bursts>;
template <class M>
using FixedSize = std::integral_constant<int, M::nx>;
template <class M>
using RuntimeSize = decltype(object<const M>().nx() + object<const M>().channels() + object<const M>().values() +
                             object<const M>().state_bytes());

} // namespace model_concept

// Whether the sizes of a model are known at compile time.
template <class Model>
constexpr bool has_fixed_size = model_concept::Answers<model_concept::FixedSize, Model>::value;

// Whether a part of its state changes at few events only.
template <class Model>
constexpr bool has_seldom_part = model_concept::Answers<model_concept::SeldomChanges, Model>::value;

// Whether its flow reads only the first numbers of x.
template <class Model>
constexpr bool reads_in_part = model_concept::Answers<model_concept::Read, Model>::value;

// Mask of its channels whose samples of one stamp come from a FIFO.
template <class Model>
constexpr std::uint64_t bursts_of() {
    if constexpr (model_concept::Answers<model_concept::Bursts, Model>::value) return Model::bursts;
    else return ~std::uint64_t{0};
}

// Whether it may have events of its own between those of the filter.
template <class Model>
constexpr bool may_cross = model_concept::Answers<model_concept::Crosses, Model>::value;

// Whether it has a solver for stiff intervals.
template <class Model>
constexpr bool may_stiffen = model_concept::Answers<model_concept::Stiff, Model>::value;

// Whether it can hold its estimate over an interval that cannot be integrated, and at a sample that gives no valid state.
template <class Model>
constexpr bool may_hold = model_concept::Answers<model_concept::Hold, Model>::value;

template <class Model>
auto sizes_of(const Model& model) {
    if constexpr (has_fixed_size<Model>) return FixedSizes<typename Model::Event, typename Model::State>{};
    else return RuntimeSizes{model.channels(), model.values(), model.state_bytes()};
}

// The number of continuous states; -1 (Eigen's Dynamic) if it is set at run time.
template <class Model>
constexpr int compiled_nx() {
    if constexpr (has_fixed_size<Model>) return Model::nx;
    else return -1;
}

template <class Model>
constexpr int nx_of(const Model& model) {
    if constexpr (has_fixed_size<Model>) return Model::nx;
    else return model.nx();
}

// The context that a solver passes to the flow.
template <class Model, class = void>
struct FlowContext {
    const Model* model;
    const typename Model::State* held;

    int flow(const model_concept::Real<Model>* x, model_concept::Real<Model>* dx) const {
        if constexpr (model_concept::flow_may_fail<Model>) return model->flow(*held, x, dx);
        model->flow(*held, x, dx);
        return 0;
    }
};
template <class Model>
struct FlowContext<Model, std::void_t<typename Model::Piece>> {
    const Model* model;
    const typename Model::State* held;
    typename Model::Piece piece{};

    int flow(const double* x, double* dx) const { return model->flow(*held, x, dx, piece); }
};

// Static assertions: the compiler names what a model lacks.
template <class M>
constexpr bool check_model() {
    using namespace model_concept;
    if constexpr (!has_fixed_size<M>) {
        static_assert(Answers<RuntimeSize, M>::value, "nx is a constant, or nx(), channels(), values() and state_bytes() say it");
        static_assert(std::is_same_v<State<M>, RuntimeState> && std::is_same_v<Event<M>, RuntimeEvent>);
    }
    static_assert(std::is_copy_assignable_v<M> && std::is_default_constructible_v<M>, "a model is a value");
    static_assert(std::is_trivially_copyable_v<State<M>>, "a state is numbers only");
    static_assert(Answers<Begin, M>::value, "void begin(State&) const");
    static_assert(Answers<Flows, M>::value, "bool flows(const State&) const");
    static_assert(Answers<Flow, M>::value, "void flow(const State&, const double* x, double* dx) const");
    static_assert(Answers<Nominal, M>::value, "void nominal(double* x) const");
    static_assert(Answers<Plausible, M>::value, "bool plausible(const State&) const");
    static_assert(Answers<Normalise, M>::value, "void normalise(State&) const");
    static_assert(Answers<BeforeFlow, M>::value, "void before_flow(State&, const Event&) const");
    static_assert(Answers<Jump, M>::value, "void jump(State&, const Event&) const");
    static_assert(M::has_closed_form == Answers<FlowExactly, M>::value, "has_closed_form: flow_exactly(State&, double) const");
    static_assert(M::bounds_rate == Answers<FastestRate, M>::value, "bounds_rate: double fastest_rate(const State&) const");
    static_assert(M::reholds == Answers<Rehold, M>::value, "reholds: rehold(State&, const Event&, double) const");
    static_assert(M::turns_back == Answers<TurnBack, M>::value, "turns_back: turn_back(State&, double) const");
    return true;
}

} // namespace hnav
