// Which derivatives of states depend on which estimated numbers, and groups of columns of which no row depends on two: one difference, or
// one directional derivative, serves a group (Curtis, Powell and Reid 1974).
#pragma once

#include "observer/problem.hpp"

namespace hnav::observer {

class Dependencies {
public:
    struct Indices {
        const int *first, *last;
        const int* begin() const { return first; }
        const int* end() const { return last; }
        int count() const { return static_cast<int>(last - first); }
    };

    // On an arena without memory it only counts.
    Dependencies(Arena& arena, const Problem& problem);

    // declared: those that the plant declares; otherwise all rows depend on all columns.
    void create(const Plant& plant, bool declared);
    void take(const Dependencies& from);

    // Columns of a moving row, ascending; rows of derivatives in a column.
    Indices row(int i) const { return {columns_ + row_begin_[i], columns_ + row_begin_[i + 1]}; }
    Indices column(int j) const { return {rows_ + column_begin_[j], rows_ + column_begin_[j + 1]}; }
    int first_group(Variable v) const { return first_group_[int(v)]; }
    int last_group(Variable v) const { return first_group_[int(v) + 1]; }
    Indices group(int g) const { return {members_ + group_begin_[g], members_ + group_begin_[g + 1]}; }

private:
    void make_columns();
    void make_groups();
    bool is_free(int column) const;

    const Problem& problem_;
    int *row_begin_, *columns_, *column_begin_, *rows_, *group_begin_, *members_, *taken_, *group_of_;
    int first_group_[variables + 1] = {};
};

} // namespace hnav::observer
