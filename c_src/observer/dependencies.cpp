#include "observer/dependencies.hpp"

#include <algorithm>
#include <initializer_list>

namespace hnav::observer {

Dependencies::Dependencies(Arena& arena, const Problem& problem)
    : problem_(problem),
      row_begin_(arena.integers(problem.moving + 1)),
      columns_(arena.integers(problem.moving * problem.N)),
      column_begin_(arena.integers(problem.N + 1)),
      rows_(arena.integers(problem.n * problem.N)),
      group_begin_(arena.integers(problem.N + 1)),
      members_(arena.integers(problem.N)),
      taken_(arena.integers(problem.n)),
      group_of_(arena.integers(problem.N)) {}

// Declarations are about states and inputs: parameters may act on every row.
void Dependencies::create(const Plant& plant, bool declared) {
    const int n = problem_.n, moving = problem_.moving, N = problem_.N;
    int used = 0;
    for (int i = 0; i < moving; ++i) {
        row_begin_[i] = used;
        for (int j = 0; j < N; ++j) {
            const bool depends = i >= n ? j == i : !declared || j >= moving || plant.depends(i, j);
            if (depends) columns_[used++] = j;
        }
    }
    row_begin_[moving] = used;
    make_columns();
    make_groups();
}

void Dependencies::make_columns() {
    const int n = problem_.n, N = problem_.N;
    int used = 0;
    std::fill_n(group_of_, N, 0); // the next place of each column
    for (int i = 0; i < n; ++i)
        for (const int j : row(i)) ++group_of_[j];
    for (int j = 0; j < N; ++j) {
        column_begin_[j] = used;
        used += group_of_[j];
        group_of_[j] = column_begin_[j];
    }
    column_begin_[N] = used;
    for (int i = 0; i < n; ++i)
        for (const int j : row(i)) rows_[group_of_[j]++] = i;
}

// Each column joins the first group with which it shares no row.
void Dependencies::make_groups() {
    constexpr int none = -1;
    int groups = 0, used = 0;
    std::fill_n(group_of_, problem_.N, none);
    for (const Variable v : {Variable::state, Variable::unknown_input, Variable::parameter}) {
        first_group_[int(v)] = groups;
        const int first = problem_.sizes.first(v), last = first + problem_.sizes.count(v);
        for (; used < last; ++groups) {
            group_begin_[groups] = used;
            std::fill_n(taken_, problem_.n, 0);
            for (int j = first; j < last; ++j) {
                if (group_of_[j] != none || !is_free(j)) continue;
                for (const int i : column(j)) taken_[i] = 1;
                group_of_[j] = groups;
                members_[used++] = j;
            }
        }
    }
    first_group_[variables] = groups;
    group_begin_[groups] = used;
}

bool Dependencies::is_free(int j) const {
    for (const int i : column(j))
        if (taken_[i] != 0) return false;
    return true;
}

void Dependencies::take(const Dependencies& from) {
    std::copy_n(from.row_begin_, problem_.moving + 1, row_begin_);
    std::copy_n(from.columns_, from.row_begin_[problem_.moving], columns_);
    make_columns();
    make_groups();
}

} // namespace hnav::observer
