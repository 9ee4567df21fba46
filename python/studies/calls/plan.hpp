// What the driver is given of an archive: its plan, as driver.cpp describes it.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

struct Variable {
    unsigned reference;
    char type, causality;
    int count;
    double min, max;
};

struct Plan {
    int version = 0;
    bool model_exchange = false;
    std::string token, resources;
    int nx = 0;
    std::vector<Variable> variables;
};

inline Plan read_plan(const char* path) {
    std::ifstream file(path);
    Plan plan;
    std::string kind;
    std::size_t n = 0;
    file >> plan.version >> kind >> std::ws;
    plan.model_exchange = kind == "ME";
    std::getline(file, plan.token);
    std::getline(file, plan.resources);
    file >> plan.nx >> n;
    plan.variables.resize(n);
    for (Variable& v : plan.variables) {
        std::string low, high; // streams do not read inf
        file >> v.reference >> v.type >> v.causality >> v.count >> low >> high;
        v.min = std::strtod(low.c_str(), nullptr), v.max = std::strtod(high.c_str(), nullptr);
    }
    if (!file) {
        std::fprintf(stderr, "%s is no plan\n", path);
        std::exit(2);
    }
    return plan;
}
