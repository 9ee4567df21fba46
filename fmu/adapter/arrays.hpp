// Consecutive rows that form one array: NAME[1], NAME[2], ... or NAME[1,1], NAME[1,2], ... With ModelInfo::arrays, FMI 3
// declares such an array as one variable.
#pragma once

#include "adapter/variable.hpp"

#include <cstring>

namespace hnav::fmu {

// A name in parts: base[i] or base[i,j], and what follows, such as the bracket of der(q[1]).
struct ElementName {
    char base[64] = "";
    int i = 0, j = 0; // 0: has none

    explicit ElementName(const char* name) {
        const char *open = std::strchr(name, '['), *close = open ? std::strchr(open, ']') : nullptr;
        if (!close || std::sscanf(open, "[%d,%d]", &i, &j) < 1) {
            std::snprintf(base, sizeof base, "%s", name);
            return;
        }
        std::snprintf(base, sizeof base, "%.*s%s", static_cast<int>(open - name), name, close + 1);
    }
    bool begins() const { return i == 1 && (j == 0 || j == 1); }
    bool follows(const ElementName& first) const { return i > 0 && !begins() && std::strcmp(base, first.base) == 0; }
};

// Number of rows of the variable that begins at a row: 1 for a scalar, 0 for a row inside an array.
inline int rows_of_variable(const Table& table, int row) {
    const ElementName first(table[row].name);
    if (first.i == 0) return 1;
    if (!first.begins()) return 0;
    int count = 1;
    while (row + count < table.size() && ElementName(table[row + count].name).follows(first)) ++count;
    return count;
}

// Value reference of the variable that begins at a row. The variables are numbered from 1 in their order, because OMSimulator
// treats value references of FMI 3 as positions.
inline int reference_of(const Table& table, int row, bool arrays) {
    if (!arrays) return row + 1;
    int count = 0;
    for (int i = 0; i <= row; ++i) count += rows_of_variable(table, i) > 0;
    return count;
}

// n x n in the row-by-row order of FMI; 0 for an array declared as a vector, such as a triangle or a matrix column by column.
inline int matrix_size(const Table& table, int row, int count) {
    const ElementName last(table[row + count - 1].name);
    if (count < 2 || last.i * last.j != count) return 0;
    return ElementName(table[row + 1].name).j == 2 ? last.i : 0;
}

} // namespace hnav::fmu
