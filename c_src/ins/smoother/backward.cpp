// Backward: from the last correction to the first, and the rows between them.
#include "ins/smoother/passes.hpp"

namespace hnav::ins {

constexpr double linear_rad = 0.005; // sigma of a heading at which the linearisation is accurate
// A second pass pays where hindsight is so much sharper than the filter was. It is linearised about rates integrated back from its end,
// and those of a walker are degrees off after minutes.
constexpr double sharper = 2;

// Returns false, and leaves `now` the filter's, where hindsight is of no use: the way back begins again.
bool Smoother::now_from(const State& filtered, const Later& later, Hindsight* now) {
    Hindsight smoothed = *now;
    if (!step_back(later.step, later.hindsight, &smoothed) || !is_of_use(filtered, smoothed)) return false;
    *now = smoothed;
    return true;
}

void Smoother::go_back(const Way& way, const Target* target) {
    Later later{};
    bool covered = false, tried = false; // a second pass has covered the rest before this node; it has been tried
    for (std::size_t piece = way.count; piece-- > 0;) {
        std::size_t nodes = go_through(way, piece), rows = rows_of_piece_;
        while (nodes > 0) {
            const Node& node = nodes_[--nodes];
            const bool linked = node.linked;
            if (!covered) {
                Hindsight now{{}, Covariance::of(node.state)};
                if (target) now = seen_from(node.state, *target);
                else if (later.known) later.known = now_from(node.state, later, &now);
                target = nullptr;
                write_rows(nodes, now, later, &rows);
                later = {linked, node.state.last_event_s, node.step, before_samples(node.step, now, node.state)};
                const double filtered2 = node.state.P[packed(row_phi + 2, row_phi + 2)],
                             smoothed2 = now.P[row_phi + 2][row_phi + 2];
                const bool wide = filtered2 > std::fmax(square(linear_rad), square(sharper) * smoothed2);
                if (!way.model.has_given_state(node.state) && (!linked || (wide && !tried))) {
                    covered = go_back_before(Node(node), now, piece);
                    tried = true;
                    go_through(way, piece);
                }
            }
            if (linked) continue;
            covered = tried = false;
            later.known = false;
            earned_ = 0;
        }
    }
}

// Writes the rows between this correction and the next.
void Smoother::write_rows(std::size_t k, const Hindsight& now, const Later& later, std::size_t* rows) {
    for (; *rows > 0; --*rows) {
        const RowOfPiece& row = rows_[*rows - 1];
        if (row.nodes != 0 && row.nodes != k + 1) return;
        if (row.nodes == 0) continue;
        earned_ |= flags_[row.row];
        if (later.known) write_row(nodes_[k].state, row, now, later);
    }
}

// The smoothed error changes little from one correction to the next, so it is interpolated in between.
void Smoother::write_row(const State& node, const RowOfPiece& row, const Hindsight& now, const Later& later) {
    const double share = std::fmin(1, std::fmax(0, (row.t_s - node.last_event_s) / (later.t_s - node.last_event_s)));
    double error[errors];
    for (int i = 0; i < errors; ++i) error[i] = now.error[i] + share * (later.hindsight.error[i] - now.error[i]);
    State s = node;
    std::copy(row.x, row.x + nx, s.x);
    add_error(error, s);
    SmoothedRow out{};
    Navigation& n = out.navigation;
    const Matrix3 to_north = show_motion(s, mat(s.axes), &n);
    const auto sigma = [&](int row) {
        return sigmas_along(to_north, (1 - share) * now.P.block(row, row) + share * later.hindsight.P.block(row, row));
    };
    n.sigma_position = sigma(row_d);
    n.sigma_velocity = sigma(row_v);
    n.sigma_rotation = sigma(row_phi);
    constexpr double no_slow_m[2] = {0, 0};
    n.protection = protection_of(n.sigma_position, n.sigma_rotation[2], 1, no_slow_m);
    out.gyro_bias = vec(s.gyro_bias);
    out.accel_bias = vec(s.accel_bias);
    const Options& options = model_.options();
    const double lie = std::sqrt(std::fmax(1, node.nis_mean));
    const auto ready = [&](int flag, int row, int rows, double largest, double limit) {
        return (earned_ >> flag & 1) != 0 && largest * lie < limit && is_expected(node, now, row, rows);
    };
    n.tilt_ready = ready(0, row_phi, 2, n.sigma_rotation.head<2>().maxCoeff(), options.ready_tilt_rad);
    n.heading_ready = ready(1, row_phi + 2, 1, n.sigma_rotation[2], options.ready_heading_rad);
    n.velocity_ready = ready(2, row_v, 3, n.sigma_velocity.maxCoeff(), options.ready_velocity_m_s);
    n.position_ready = ready(3, row_d, 2, n.sigma_position.head<2>().maxCoeff(), options.ready_position_m);
    recording_.write(row.row, out);
}

} // namespace hnav::ins
